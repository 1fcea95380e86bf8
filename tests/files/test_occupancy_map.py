import io
import math
from pathlib import Path

import numpy as np
import pytest
from benchmarks.scanned_floors import Floor, drawn_floor, write_floor
from PIL import Image
from scipy import ndimage
from shapely import LineString, MultiPolygon, Point, Polygon, box, get_coordinates, hausdorff_distance, union_all

from rota.errors import MissionError
from rota.files.map_image import read_brightness
from rota.files.mission_file import read_mission
from rota.files.occupancy_map import GapsError, InsideError, read_map
from rota.files.pixel_outline import exact_outline, sealed_outline, straight_outline

ROOT = Path(__file__).parent.parent.parent
CUMBERLAND = ROOT.parent / "shared" / "data" / "maps" / "cumberland.yaml"

ROOM = np.full((6, 8), 254, dtype=np.uint8)
ROOM[[0, -1]] = ROOM[:, [0, -1]] = 0


def pgm(pixels, kind="P5", maxval=255):
    head = f"{kind}\n# drawn by hand\n{pixels.shape[1]} # columns\n{pixels.shape[0]}\n{maxval}\n".encode()
    if kind == "P2":
        return head + b"\n".join(b" ".join(b"%d" % value for value in row) for row in pixels) + b" # end\n"
    return head + pixels.astype(">u2" if maxval > 255 else "u1").tobytes()


def write_map(folder, pixels=ROOM, *, image=None, name="room.pgm", **keys):
    values = {
        "resolution": 0.5,
        "origin": [0, 0, 0],
        "negate": 0,
        "occupied_thresh": 0.65,
        "free_thresh": 0.196,
        **keys,
    }
    (folder / name).write_bytes(pgm(pixels) if image is None else image)
    path = folder / "room.yaml"
    path.write_text(f"image: {name}\n" + "".join(f"{key}: {value}\n" for key, value in values.items()))
    return path


def png(pixels, mode):
    data = io.BytesIO()
    Image.fromarray(pixels, mode=mode).save(data, "PNG")
    return data.getvalue()


# ---- images


@pytest.mark.parametrize(
    ("kind", "maxval"), [("P2", 255), ("P5", 255), ("P2", 15), ("P5", 15), ("P5", 1000), ("P2", 1000)]
)
def test_graymaps_of_every_depth(tmp_path, kind, maxval):
    values = np.random.default_rng(3).integers(0, maxval + 1, (7, 5))
    (tmp_path / "a.pgm").write_bytes(pgm(values, kind, maxval))
    assert read_brightness(tmp_path / "a.pgm", alpha_counts=True) == pytest.approx(values * 255 / maxval, abs=1e-12)


def test_graymaps_are_read_as_pillow_reads_them(tmp_path):
    values = np.random.default_rng(4).integers(0, 256, (40, 30)).astype(np.uint8)
    for kind in ("P2", "P5"):
        data = pgm(values, kind).replace(b" # end", b"").replace(b" # columns", b"")
        (tmp_path / "a.pgm").write_bytes(data)
        with Image.open(tmp_path / "a.pgm") as image:
            assert (read_brightness(tmp_path / "a.pgm", alpha_counts=True) == np.asarray(image)).all()


def test_colours_are_averaged_and_opacity_counts_where_map_server_counts_it(tmp_path):
    colours = np.random.default_rng(5).integers(0, 256, (4, 3, 4)).astype(np.uint8)
    path = tmp_path / "a.png"
    path.write_bytes(png(colours, "RGBA"))
    assert read_brightness(path, alpha_counts=True) == pytest.approx(colours.mean(axis=2))
    assert read_brightness(path, alpha_counts=False) == pytest.approx(colours[..., :3].mean(axis=2))
    path.write_bytes(png(np.ascontiguousarray(colours[..., :3]), "RGB"))
    assert read_brightness(path, alpha_counts=True) == pytest.approx(colours[..., :3].mean(axis=2))
    path.write_bytes(png(np.ascontiguousarray(colours[..., 0]), "L"))
    assert (read_brightness(path, alpha_counts=True) == colours[..., 0]).all()


def test_deep_grey_png(tmp_path):
    values = np.array([[0, 65535, 205 * 257]], dtype=np.uint16)
    Image.fromarray(values).save(tmp_path / "a.png")
    assert read_brightness(tmp_path / "a.png", alpha_counts=True) == pytest.approx(np.array([[0.0, 255.0, 205.0]]))


@pytest.mark.parametrize(
    ("data", "words"),
    [
        (b"P5\n4", "no height"),
        (b"P5\n4 4\n0\n", "up to 0"),
        (b"P5\n4 4\n255\n123", "3 of 4 x 4 pixels"),
        (b"P2\n2 1\n9\n3 x", "whole numbers"),
        (b"P2\n2 1\n9\n3 12", "a pixel of 12"),
        (b"P5\n99999 99999\n255\n", "coarsen"),
        (b"P6\n1 1\n255\n   ", "neither PGM"),
        (b"\x89PNG\r\n\x1a\nrubbish", "damaged PNG"),
        (png(ROOM, "L")[:-30], "damaged PNG"),
    ],
)
def test_damaged_images_are_refused(tmp_path, data, words):
    (tmp_path / "a.pgm").write_bytes(data)
    with pytest.raises(MissionError, match=words):
        read_brightness(tmp_path / "a.pgm", alpha_counts=True)


# ---- what is free


def test_a_room_its_walls_and_its_place(tmp_path):
    sheet = read_map(write_map(tmp_path, origin=[10, 20, 0]), (11, 21))
    assert sheet.area.equals(box(10.5, 20.5, 13.5, 22.5))
    assert sheet.obstacles is not None
    assert sheet.obstacles.equals(box(10, 20, 14, 23).difference(box(10.5, 20.5, 13.5, 22.5)))
    assert sheet.warnings == ()


def test_row_0_is_the_top_and_yaw_turns_about_the_lower_left_corner(tmp_path):
    pixels = np.zeros((3, 5), dtype=np.uint8)
    pixels[0, 4] = 254
    yaw = 0.3
    lower_left = np.array([1.0, 2.0]) + 0.5 * np.array(
        [4 * math.cos(yaw) - 2 * math.sin(yaw), 4 * math.sin(yaw) + 2 * math.cos(yaw)]
    )
    middle = lower_left + 0.25 * np.array([math.cos(yaw) - math.sin(yaw), math.sin(yaw) + math.cos(yaw)])
    sheet = read_map(write_map(tmp_path, pixels, origin=[1, 2, yaw]), tuple(middle))
    assert sheet.area.area == pytest.approx(0.25)
    assert sheet.area.centroid.distance(Point(middle)) < 1e-12
    assert sheet.area.exterior.distance(Point(lower_left)) < 1e-12 if isinstance(sheet.area, Polygon) else True
    assert min(np.hypot(*(get_coordinates(sheet.area) - lower_left).T)) < 1e-12


def test_area_and_obstacles_share_their_border_exactly(tmp_path):
    rng = np.random.default_rng(11)
    pixels = np.where(ndimage.gaussian_filter(rng.random((60, 80)), 2) > 0.5, 254, 0).astype(np.uint8)
    free = np.argwhere(ndimage.label(pixels[::-1])[0] == 1)[0]
    inside = _in_metres(free[1] + 0.5, free[0] + 0.5, (3.0, -4.0, 1.1))
    sheet = read_map(write_map(tmp_path, pixels, origin=[3, -4, 1.1]), inside)
    assert sheet.obstacles is not None
    theirs = {tuple(point) for point in get_coordinates(sheet.obstacles)}
    corners = {_in_metres(x, y, (3.0, -4.0, 1.1)) for x in (0, 80) for y in (0, 60)}
    ours = {tuple(point) for point in get_coordinates(sheet.area)}
    assert len(ours - theirs) <= len(corners)
    assert sheet.area.intersection(sheet.obstacles).area == pytest.approx(0, abs=1e-9)
    assert sheet.area.area + sheet.obstacles.area == pytest.approx(60 * 80 * 0.25)


def _in_metres(column, row, origin):
    x, y, yaw = origin
    cos, sin = 0.5 * math.cos(yaw), 0.5 * math.sin(yaw)
    return x + cos * column - sin * row, y + sin * column + cos * row


def test_only_the_part_with_the_point_and_corners_connect_nothing(tmp_path):
    pixels = np.zeros((4, 4), dtype=np.uint8)
    pixels[2:, :2] = pixels[:2, 2:] = 254
    sheet = read_map(write_map(tmp_path, pixels), (0.5, 0.5))
    assert sheet.area.equals(box(0, 0, 1, 1))
    assert sheet.obstacles is not None
    assert sheet.obstacles.area == pytest.approx(3)


@pytest.mark.parametrize(
    ("value", "keys", "is_free"),
    [
        # occupancy (255 - value) / 255 must lie below free_thresh
        (206, {}, True),
        (205, {}, False),
        (205, {"free_thresh": 0.25}, True),
        (50, {"negate": 1}, False),
        (49, {"negate": 1}, True),
        (49, {"negate": "true"}, True),
        # exactly on the threshold is not below it
        (204, {"free_thresh": 0.2}, False),
    ],
)
def test_thresholds_as_map_server_compares_them(tmp_path, value, keys, is_free):
    sure, wall = (0, 255) if keys.get("negate") else (254, 0)
    pixels = np.array([[wall, wall, wall], [sure, value, wall]], dtype=np.uint8)
    sheet = read_map(write_map(tmp_path, pixels, **keys), (0.25, 0.25))
    assert sheet.area.area == (0.5 if is_free else 0.25)
    assert bool(sheet.warnings) == (value == 205 and is_free)


@pytest.mark.parametrize(
    ("unknown", "area_m2", "warns"), [("map_server reading", 0.75, True), ("blocked", 0.5, False), ("free", 1.0, False)]
)
def test_unknown_cells(tmp_path, unknown, area_m2, warns):
    # free, by convention unknown but read as free, free, between the thresholds
    pixels = np.array([[254, 254, 205, 150, 0]], dtype=np.uint8)
    sheet = read_map(write_map(tmp_path, pixels, free_thresh=0.25), (0.25, 0.25), unknown)
    assert sheet.area.area == area_m2
    assert bool(sheet.warnings) == warns
    if warns:
        assert "1 cells have the value 205" in sheet.warnings[0]


def test_a_sheet_that_is_free_throughout_has_no_obstacles(tmp_path):
    sheet = read_map(write_map(tmp_path, np.full((3, 4), 254, dtype=np.uint8)), (1, 1))
    assert (sheet.area.area, sheet.obstacles) == (3.0, None)


def test_inside_a_wall_tells_the_nearest_free_place(tmp_path):
    path = write_map(tmp_path)
    with pytest.raises(InsideError, match=r"wall.* nearest free place is 0\.3 m away, at \[0\.75, 1\.25\]"):
        read_map(path, (0.2, 1.3))
    with pytest.raises(InsideError, match=r"off the map .* 5 m away, at \[3\.25, 2\.25\]"):
        read_map(path, (3.5 + 3, 2.5 + 4))
    read_map(path, (0.75, 1.25))


@pytest.mark.parametrize(
    ("keys", "words"),
    [
        ({"resolution": '"0.5"'}, r"room\.yaml:2:13: resolution: \"0\.5\" is not allowed; a number is needed"),
        ({"origin": "[0, 0]"}, "origin: .* too short; 3 numbers are needed"),
        ({"negate": 2}, "negate: 2 is not allowed"),
        ({"mode": "raw"}, '"raw" is not allowed; trinary or scale is needed'),
        ({"free_thresh": 65}, "at most 1"),
        ({"free_thresh": 0.7}, "above occupied_thresh"),
    ],
)
def test_wrong_map_files_are_refused(tmp_path, keys, words):
    with pytest.raises(MissionError, match=words):
        read_map(write_map(tmp_path, **keys), (1, 1))


# ---- outlines


def noise(seed, smooth, size=70):
    field = ndimage.gaussian_filter(np.random.default_rng(seed).random((size, size)), smooth) > 0.5
    labels, _ = ndimage.label(field)
    return np.asarray(labels == np.bincount(labels.ravel())[1:].argmax() + 1)


def slanted_hall(degrees, size=120):
    rows, columns = np.mgrid[0:size, 0:size] + 0.5 - size / 2
    angle = math.radians(degrees)
    along = columns * math.cos(angle) + rows * math.sin(angle)
    across = rows * math.cos(angle) - columns * math.sin(angle)
    return (np.abs(along) < size * 0.4) & (np.abs(across) < size * 0.2)


def distance_from_each_to(border, other):
    """Farthest that any point of the one border is from the other one; points every 0.05 pixels."""
    steps = np.arange(0, border.length, 0.05)
    return max(other.distance(border.interpolate(step)) for step in steps)


def test_the_exact_outline_is_the_union_of_the_pixels():
    for seed in range(5):
        pixels = noise(seed, 0.7, 25)
        rows, columns = np.nonzero(pixels)
        assert exact_outline(pixels).equals(union_all(box(columns, rows, columns + 1, rows + 1)))


@pytest.mark.parametrize("smooth", [0, 0.6, 1, 2])
def test_straightening_moves_the_border_by_half_a_pixel_at_most(smooth):
    for seed in range(4):
        pixels = noise(seed, smooth)
        exact, straight = sealed_outline(pixels), straight_outline(pixels)
        assert straight.is_valid
        assert len(straight.geoms) == len(exact.geoms) == 1
        assert len(straight.geoms[0].interiors) == len(exact.geoms[0].interiors)
        assert hausdorff_distance(exact.boundary, straight.boundary, densify=0.05) <= 0.5 + 1e-9
        assert len(get_coordinates(straight)) <= len(get_coordinates(exact))


def test_straightening_by_brute_force():
    pixels = noise(9, 1, 30)
    exact, straight = sealed_outline(pixels), straight_outline(pixels)
    for ring, other in ((straight.boundary, exact.boundary), (exact.boundary, straight.boundary)):
        parts = ring.geoms if hasattr(ring, "geoms") else [ring]
        assert max(distance_from_each_to(part, other) for part in parts) <= 0.5 + 1e-9


def test_stairs_become_straight_walls():
    pixels = slanted_hall(45)
    assert len(get_coordinates(exact_outline(pixels))) > 150
    assert len(get_coordinates(straight_outline(pixels))) < 15


def test_rectangles_stay_as_they_are():
    pixels = np.zeros((20, 30), dtype=bool)
    pixels[2:18, 3:25] = True
    pixels[6:9, 10:14] = False
    assert straight_outline(pixels).equals(MultiPolygon([box(3, 2, 25, 18).difference(box(10, 6, 14, 9))]))


def test_thin_slanted_walls_do_not_close_or_open():
    pixels = np.ones((40, 40), dtype=bool)
    for k in range(5, 35):
        pixels[k, k] = pixels[k, k + 1] = False
    straight = straight_outline(pixels)
    assert straight.is_valid
    assert len(straight.geoms[0].interiors) == 1
    assert not straight.contains(Point(20.5, 20.5))


def test_nothing_is_seen_between_cells_that_touch_at_a_corner():
    chain = np.ones((30, 30), dtype=bool)
    chain[range(5, 25), range(5, 25)] = False
    for pixels in (chain, chain[::-1]):
        sealed = sealed_outline(pixels)
        assert len(exact_outline(pixels).geoms[0].interiors) == 20
        assert len(sealed.geoms[0].interiors) == 1
        assert sealed.area == pytest.approx(900 - 20 - 19 * 0.01)
        for outline in (sealed, straight_outline(pixels)):
            # from one side through the places where two of the cells touch, and from farther along the chain
            flip = -1 if pixels is not chain else 1
            through = [((k - 3, 15 + flip * (k - 12)), (k + 3, 15 + flip * (k - 18))) for k in range(10, 20)]
            assert not any(outline.covers(LineString(line)) for line in through)
            assert all(exact_outline(pixels).covers(LineString(line)) for line in through)


def test_a_part_joined_by_a_corner_only_is_sealed_off_too():
    pixels = np.zeros((6, 6), dtype=bool)
    pixels[0:3, 0:3] = pixels[3:6, 3:6] = True
    assert sealed_outline(pixels).area == pytest.approx(18 - 0.01)
    assert not sealed_outline(pixels).geoms[0].intersects(sealed_outline(pixels).geoms[1])


# ---- gaps


def test_gaps_and_nooks_narrower_than_asked_are_closed(tmp_path):
    """Two halls with a gap of two cells and one of three between them, and nooks as wide in the walls."""
    pixels = np.zeros((14, 25), dtype=np.uint8)
    pixels[1:13, 1:11] = pixels[1:13, 14:24] = 254
    pixels[2:4, 10:15] = pixels[7:10, 10:15] = 254  # gaps
    pixels[0, 3:5] = pixels[0, 17:20] = 254  # nooks
    path = write_map(tmp_path, pixels, resolution=0.05)
    area_m2 = {
        gaps_m: read_map(path, (0.1, 0.1), close_gaps_m=gaps_m).area.area for gaps_m in (0.0, 0.05, 0.1, 0.15, 0.2)
    }
    cells = {gaps_m: round(value / 0.05**2) for gaps_m, value in area_m2.items()}
    halls, gaps, nooks = 240, (6, 9), (2, 3)
    assert cells[0.0] == cells[0.05] == halls + sum(gaps) + sum(nooks)
    assert cells[0.1] == cells[0.0]  # as wide as asked, so they stay
    assert cells[0.15] == halls + gaps[1] + nooks[1]
    # the hall of the point alone, less the corners that a disc of four cells does not fill, cut straight
    assert halls // 2 - 4 - 4 / 2 == cells[0.2]


def test_what_gaps_leave_is_the_union_of_discs(tmp_path):
    """By brute force: every disc of whole cells that lies in free ones."""
    free = noise(3, 1.0, 40)
    path = write_map(tmp_path, np.where(free[::-1], 254, 0).astype(np.uint8), resolution=1.0)
    for cells in (2, 3, 4, 5):
        left = np.zeros_like(free)
        for row in range(41 - cells):
            for column in range(41 - cells):
                rows, columns = np.mgrid[row : row + cells, column : column + cells]
                away = np.hypot(rows - row - (cells - 1) / 2, columns - column - (cells - 1) / 2)
                disc = rows[away <= cells / 2], columns[away <= cells / 2]
                if free[disc].all():
                    left[disc] = True
        labels, count = ndimage.label(left)
        largest = labels == np.bincount(labels[left]).argmax()
        row, column = np.argwhere(largest)[0]
        area = read_map(path, (column + 0.5, row + 0.5), close_gaps_m=float(cells)).area
        assert count >= 1
        assert area.equals(straight_outline(largest))


@pytest.mark.parametrize(
    ("gaps_m", "error", "words"),
    [
        (10.5, GapsError, r"10\.5 is not allowed; at most 10 m are, 20 cells of .*room\.yaml"),
        (3.0, GapsError, r"closes all of the free space of .*room\.yaml; nowhere is it 3 m wide"),
        (2.0, InsideError, r"wall, in unknown space or in a gap that is closed; .* at \[1\.25, 0\.75\]"),
    ],
)
def test_gaps_that_cannot_be_closed_are_told(tmp_path, gaps_m, error, words):
    with pytest.raises(error, match=words):
        read_map(write_map(tmp_path), (0.75, 0.75), close_gaps_m=gaps_m)


def test_gaps_narrower_than_two_cells_are_warned_of(tmp_path):
    assert not read_map(write_map(tmp_path), (0.75, 0.75), close_gaps_m=1.0).warnings
    sheet = read_map(write_map(tmp_path), (0.75, 0.75), close_gaps_m=0.9)
    assert "close_gaps_m 0.9 closes nothing; two cells of" in sheet.warnings[0]


def test_a_ragged_floor_as_missions_write_it(tmp_path):
    floor = Floor(columns=400, rows=300, turned_deg=3.0, ragged=0.35, speckle=0.3)
    mission = write_floor("floor", floor, 1, tmp_path)
    ragged = read_mission(mission).mission.area
    mission.write_text(mission.read_text().replace("unknown: blocked", "unknown: blocked, close_gaps_m: 0.15"))
    closed = read_mission(mission).mission.area
    assert len(get_coordinates(closed)) < 0.75 * len(get_coordinates(ragged))
    assert 0.97 * ragged.area < closed.area < ragged.area
    for wrong, words in [("2", r"2 is not allowed; at most 1 m are"), ("-1", "at least 0.001"), ("wide", "a number")]:
        mission.write_text(mission.read_text().replace("close_gaps_m: 0.15", f"close_gaps_m: {wrong}"))
        with pytest.raises(MissionError, match=rf"floor\.yaml:3:\d+: area\.close_gaps_m: .*{words}"):
            read_mission(mission)
        mission.write_text(mission.read_text().replace(f"close_gaps_m: {wrong}", "close_gaps_m: 0.15"))
    mission.write_text("rota: 1\nname: a\narea: {ring: [[0, 0], [9, 0], [9, 9]], close_gaps_m: 0.1}\n")
    with pytest.raises(MissionError, match="close_gaps_m: belongs to a map"):
        read_mission(mission)


# ---- whole maps


def test_the_building_of_the_examples():
    mission = read_mission(ROOT / "examples" / "building.yaml").mission
    assert len(mission.obstacles) == 1
    # 24 m x 16 m less walls, furniture and the corner that is cut off
    assert 340 < mission.area.area < 384
    assert all(mission.area.contains(Point(x, y)) for x, y in [(1, 1), (23, 1), (0.5, 15), (15, 12), (21, 14), (12, 8)])
    # a body of 0.2 m gets through every door
    assert mission.area.buffer(-0.2).geom_type == "Polygon"


def drawn_building(folder):
    """A scan of a made building: its path, a place in it, and the brightest grey that is blocked."""
    floor = Floor(columns=688, rows=499, pixel_m=0.075, turned_deg=2.0, speckle=0.05)
    write_floor("floor", floor, 1, folder)
    return folder / "floor-map.yaml", drawn_floor(floor, 1)[1], 255 * (1 - 0.196)


def real_building(folder):
    """The same of a real building, whose files are not part of the project."""
    return CUMBERLAND, (44, 7), 255 * (1 - 0.19)


needs_real_inputs = pytest.mark.skipif(not CUMBERLAND.exists(), reason="../shared/data is missing")


@pytest.mark.parametrize("building", [drawn_building, pytest.param(real_building, marks=needs_real_inputs)])
def test_a_whole_building(building, tmp_path):
    """One part of the image, with all that is not in it, as large as its pixels and nowhere half a pixel off."""
    path, inside, brightest_blocked = building(tmp_path)
    sheet = read_map(path, inside)
    with Image.open(path.with_suffix(".pgm")) as image:
        labels, _ = ndimage.label(np.asarray(image)[::-1] > brightest_blocked)
    part = labels == labels[int(inside[1] / 0.075), int(inside[0] / 0.075)]
    assert sheet.area.is_valid
    assert len(sheet.area.geoms) == 1
    assert sheet.area.area == pytest.approx(part.sum() * 0.075**2, rel=0.002)
    assert sheet.obstacles is not None
    assert sheet.obstacles.is_valid
    assert sheet.area.area + sheet.obstacles.area == pytest.approx(688 * 499 * 0.075**2)
    exact_m = exact_outline(part)
    assert hausdorff_distance(exact_m.boundary, straight_outline(part).boundary, densify=0.05) <= 0.5 + 1e-9
    with pytest.raises(InsideError):
        read_map(path, (0.05, 37.4))
