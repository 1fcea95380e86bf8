// One virtual vehicle of Siemens' vda-5050-lib as it is published; the only argument is JSON.
//
// port: the broker's. serial, version: the vehicle's. x, y: where it stands. speed: in m/s. ticks: its steps a second.
// battery: its charge in percent. fills: hours in which it is filled.
// clock, zero: its time passes `clock` times as fast since the Unix time `zero` in seconds.
// It prints a line of JSON for each node that it reaches and for all errors that it reports.

const given = JSON.parse(process.argv[2]);
const RealDate = Date;
const zero = given.zero * 1000;
globalThis.Date = class extends RealDate {
    constructor(...parts) {
        super(...(parts.length ? parts : [globalThis.Date.now()]));
    }
    static now() {
        return zero + (RealDate.now() - zero) * given.clock;
    }
};

const { AgvController, VirtualAgvAdapter } = require("vda-5050-lib");

function tell(what) {
    process.stdout.write(JSON.stringify({ robot: given.serial, unix_s: Date.now() / 1000, ...what }) + "\n");
}

class Vehicle extends AgvController {
    onStateChanged(changes) {
        if (changes.lastNodeSequenceId !== undefined) {
            tell({ sequence: changes.lastNodeSequenceId, node: changes.lastNodeId });
        }
        if (changes.errors !== undefined && changes.errors.length > 0) {
            tell({ errors: changes.errors });
        }
    }
}

const client = {
    interfaceName: "uagv",
    transport: { brokerUrl: `mqtt://127.0.0.1:${given.port}` },
    vdaVersion: given.version,
};
const controller = {
    agvAdapterType: VirtualAgvAdapter,
    publishStateInterval: 30000 / given.clock,
    publishVisualizationInterval: 1000 / given.clock,
};
const adapter = {
    initialPosition: { mapId: "map", x: given.x, y: given.y, theta: 0, lastNodeId: "" },
    vehicleSpeed: given.speed,
    initialBatteryCharge: given.battery,
    fullBatteryChargeTime: given.fills,
    tickRate: given.ticks * given.clock,
};
const vehicle = new Vehicle({ manufacturer: "rota", serialNumber: given.serial }, client, controller, adapter);
vehicle.start().then(() => tell({ started: true }));
