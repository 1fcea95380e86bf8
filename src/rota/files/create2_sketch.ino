// @TITLE@
//
// An iRobot Create 2 that drives straight until it bumps, backs off and turns. It has a bump sensor and a clock and
// knows nothing else; where it is follows from where it began. Written by Rota, for an Arduino Uno.
//
// Begin:   @BEGIN@
// Then:    @THEN@
// Clock:   @CLOCK@
// Others:  @OTHERS@
//
// It plays a table of legs, made from a plan; it is not the one program for all robots that turns by a fixed angle at
// every bump, as Alam & Bobadilla 2020 have it. Two turns in one place are one turn here, the short way round; each leg
// has a speed of its own, and the clock says when the next one begins. It is lost when a bump comes too early or not in
// time, or when it is late for its plan.
//
@ROBOT@
// ---------------------------------------------------------------- the common start

// All robots must begin at the same moment. With false they count from the moment at which they are switched on, so one
// switch must do for all. With true each waits, once its robot answers, for SIGNAL_PIN to be drawn to ground twice, for
// 50 ms or more, the second time SECOND_PULSE_MS after the first, or half of that sooner or later. Later pulses, single
// ones every SIGNAL_EVERY_MS, set its clock again. Whoever hears a single one first has missed the start, and stops.
const bool WAIT_FOR_SIGNAL = false;
const uint8_t SIGNAL_PIN = 3;
const unsigned long SECOND_PULSE_MS = 600;
const unsigned long POWER_ON_TO_START_MS = 10000;  // hands off by then; a robot that wakes up later does not begin
const unsigned long SIGNAL_TO_START_MS = 3000;

// How far from where it is due a bump may come, beside a share of 1 / LOST_SHARE of the way; and how late for its plan
// the robot may be. What is beyond is not this plan any more: something stands in the way, or a door is open.
const uint16_t LOST_MM = 100;
const uint8_t LOST_SHARE = 20;
const unsigned long LATE_MS = 300;

// ---------------------------------------------------------------- the plan

// What many legs have in common.
struct __attribute__((packed)) Kind {
  int16_t speedMmS;     // forward
  uint16_t backOffMm;   // after a bump
  int16_t turnTenths;   // of a degree, to the left
  uint8_t bumps;        // a bump ends it; otherwise the clock does
};

const Kind KINDS[] PROGMEM = {
@KINDS@
};

struct __attribute__((packed)) Leg {
  uint16_t kind;
  uint32_t driveMs : 24;  // for so long, or until the bump, which is due then
  uint32_t lastsMs : 24;  // from its beginning to that of the next one, on the plan's clock
};

const Leg LEGS[] PROGMEM = {
@LEGS@
};
const uint16_t LEG_COUNT = sizeof(LEGS) / sizeof(LEGS[0]);
const bool LOOPS = @LOOPS@;          // after the last leg: on with leg LOOP_FROM, or stop
const uint16_t LOOP_FROM = @LOOP_FROM@;
const uint32_t LOOP_MS = @LOOP_MS@;    // one round, all its legs together,
const uint16_t LOOP_REST = @LOOP_REST@;    // and so many 65,536ths of a millisecond, which add up
const uint32_t FIRST_MS = @FIRST_MS@;     // when the first leg begins
const uint32_t SIGNAL_EVERY_MS = @SIGNAL_EVERY_MS@;  // a pulse that sets all clocks; 0: only the first one counts

unsigned long clockZeroMs;   // when the plan's clock showed 0
unsigned long signalDueMs;   // when the next pulse is to come
bool signalWas = false;

// True at the beginning of a pulse.
bool signalBegins() {
  const bool is = digitalRead(SIGNAL_PIN) == LOW;
  const bool begins = is && !signalWas;
  signalWas = is;
  return begins;
}

// A pulse near the time at which one is due sets the clock; others are bouncing contacts.
void heedSignal() {
  if (!WAIT_FOR_SIGNAL || SIGNAL_EVERY_MS == 0 || !signalBegins()) return;
  const unsigned long nowMs = millis();
  while (long(nowMs - signalDueMs) > long(SIGNAL_EVERY_MS / 2)) signalDueMs += SIGNAL_EVERY_MS;  // pulses were lost
  const long lateMs = long(nowMs - signalDueMs);
  if (lateMs < -long(SIGNAL_EVERY_MS / 2)) return;
  clockZeroMs += lateMs;
  signalDueMs = nowMs + SIGNAL_EVERY_MS;
}

// To be called all the time.
void watch() {
  guard();
  heedSignal();
}

// ---------------------------------------------------------------- moves

// Straight on, until it bumps or the time is up. True: it bumped. A bump much sooner than driveMs, or none when one is
// due, means that the robot is not where it should be.
bool driveOn(int16_t speedMmS, uint32_t driveMs, bool bumps) {
  const unsigned long beganMs = millis();
  const uint32_t offMs = LOST_MM * 1000UL / speedMmS + driveMs / LOST_SHARE;
  drive(speedMmS, speedMmS);
  while (true) {
    watch();
    const uint32_t goneMs = millis() - beganMs;
    if (bumped) {
      if (goneMs + offMs < driveMs) stopForGood();
      return true;
    }
    if (!bumps && goneMs >= driveMs) return false;
    if (goneMs > driveMs + offMs) stopForGood();
    doze();
  }
}

// On the plan's clock, which a pulse may set meanwhile. Too late already: lost.
void waitUntil(uint32_t planMs) {
  if (long(millis() - clockZeroMs - planMs) > long(LATE_MS)) stopForGood();
  while (long(clockZeroMs + planMs - millis()) > 0) {
    watch();
    doze();
  }
}

// ---------------------------------------------------------------- start, and leg by leg

// Sets the clock: by the common signal, or by the moment of switching on, whenever the robot wakes.
void setClock() {
  clockZeroMs = POWER_ON_TO_START_MS;
  if (WAIT_FOR_SIGNAL) {
    while (!signalBegins()) guard();
    const unsigned long firstMs = millis();
    unsigned long sinceMs = 0;
    do {  // contacts bounce sooner
      guard();
      sinceMs = millis() - firstMs;
      if (sinceMs > SECOND_PULSE_MS * 3 / 2) stopForGood();  // the start was missed: this was a later pulse
    } while (!signalBegins() || sinceMs < SECOND_PULSE_MS / 2);
    clockZeroMs = firstMs + SIGNAL_TO_START_MS;
    signalDueMs = firstMs + SIGNAL_EVERY_MS;
  } else if (millis() > POWER_ON_TO_START_MS) {
    stopForGood();
  }
}

uint16_t number = 0;  // of the leg
uint32_t nextMs = FIRST_MS;  // when the leg after it begins, on the plan's clock
uint16_t rest = 0;  // of all rounds so far

void setup() {
  pinMode(LED_BUILTIN, OUTPUT);
  pinMode(SIGNAL_PIN, INPUT_PULLUP);
  Serial.begin(BAUD);
  wake();
  startRobot();
  digitalWrite(LED_BUILTIN, HIGH);
  setClock();
  waitUntil(FIRST_MS);
}

void loop() {
  Leg leg;
  Kind kind;
  memcpy_P(&leg, &LEGS[number], sizeof(leg));
  memcpy_P(&kind, &KINDS[leg.kind], sizeof(kind));

  if (driveOn(kind.speedMmS, leg.driveMs, kind.bumps)) backOff(kind.backOffMm);
  turn(kind.turnTenths);
  stopWheels();
  nextMs += leg.lastsMs;
  waitUntil(nextMs);

  number++;
  if (number == LEG_COUNT) {
    if (!LOOPS) stopForGood();
    number = LOOP_FROM;
    nextMs -= LOOP_MS;  // the clock goes on instead, so that it never runs over
    clockZeroMs += LOOP_MS;
    const uint16_t before = rest;
    rest += LOOP_REST;
    if (rest < before) clockZeroMs++;
  }
}
