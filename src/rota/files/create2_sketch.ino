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
// has a speed of its own, and the clock says when the next one begins.
//
// Wiring, Create 2 mini-DIN socket -> Arduino Uno:
//   pin 3  RXD            -> pin 1 (TX)
//   pin 4  TXD            -> pin 0 (RX)
//   pin 5  BRC            -> pin 2 (WAKE_PIN below)
//   pin 6 or 7  ground    -> GND
//   a button or receiver for all robots -> pin 3 (SIGNAL_PIN), to ground; may be left out
//   pin 1 or 2  battery   -> 9 V regulator -> VIN; never straight to the Arduino: it is up to 20 V
// Unplug pins 0 and 1 while you upload. The LED on the Arduino is lit while all is well and blinks after a stop.
//
// It stops for good over a cliff, when it is lifted, when its wheels are stuck, when CLEAN is pressed on the robot,
// when the robot falls silent, and when it is lost: a bump came too early or not in time, or it is late for its plan.

#include <Arduino.h>
#include <avr/pgmspace.h>
#include <avr/sleep.h>

// ---------------------------------------------------------------- what you may want to change

// Let the robot turn by ten times 360 degrees: if it comes short by 2 %, this is 1.02.
const float TURN_CALIBRATION = 1.000;

// Safe mode (false): the robot itself stops at a cliff, too. Full mode (true): only this sketch does.
const bool FULL_MODE = false;

const unsigned long BAUD = 115200;        // the Create 2's own rate after power-on
const uint8_t WAKE_PIN = 2;               // to BRC: a low pulse wakes the robot

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
const unsigned long STUCK_MS = 500;  // for so long too much current for a wheel

// ---------------------------------------------------------------- the plan

const int16_t BACK_OFF_MM_S = @BACK_OFF_MM_S@;  // speed while backing off
const int16_t TURN_MM_S = @TURN_MM_S@;      // speed of each wheel while turning in place
const float WHEEL_BASE_MM = 235.0;    // from wheel to wheel

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

// ---------------------------------------------------------------- what the robot is told (Create 2 Open Interface)

const uint8_t START = 128, SAFE = 131, FULL = 132, DRIVE_DIRECT = 145, STREAM = 148;

// Signed speeds of the right and the left wheel.
void drive(int16_t rightMmS, int16_t leftMmS) {
  const uint8_t command[] = { DRIVE_DIRECT,
                              uint8_t(rightMmS >> 8), uint8_t(rightMmS),
                              uint8_t(leftMmS >> 8), uint8_t(leftMmS) };
  Serial.write(command, sizeof(command));
}

void stopWheels() {
  drive(0, 0);
}

// ---------------------------------------------------------------- what the robot tells

// Every 15 ms: 19, number of bytes, then packet and value in turn, then a byte that makes the sum 0.
const uint8_t STREAM_HEADER = 19;
// bumps and wheel drops; cliff left, front left, front right, right; overcurrents of motors; buttons
const uint8_t PACKETS[] = { 7, 9, 10, 11, 12, 14, 18 };
const uint8_t LAST_CLIFF = 4;  // its place among the packets
const uint8_t PACKET_COUNT = sizeof(PACKETS);
const uint8_t FRAME_BYTES = 2 + 2 * PACKET_COUNT + 1;
const uint8_t BUMPS = 0b0011, WHEEL_DROPS = 0b1100;  // bits of packet 7
const uint8_t WHEEL_OVERCURRENTS = 0b11000;          // of packet 14
const uint8_t CLEAN_BUTTON = 0b1;                    // of packet 18

const unsigned long SILENCE_MS = 500;  // without a frame for so long: stop

uint8_t lastBytes[FRAME_BYTES];  // as received, the newest last
bool bumped = false;
bool inDanger = false;  // over a cliff, or lifted
bool mustStop = false;  // wheels stuck, or CLEAN pressed
unsigned long freeMs = 0;  // when the wheels last had no overcurrent
unsigned long lastFrameMs = 0;
bool heard = false;  // since the start

// While it boots the robot prints text, and bytes can get lost: only what is a frame in every byte counts.
bool isFrame() {
  if (lastBytes[0] != STREAM_HEADER || lastBytes[1] != 2 * PACKET_COUNT) return false;
  uint8_t sum = 0;
  for (uint8_t i = 0; i < FRAME_BYTES; i++) sum += lastBytes[i];
  if (sum != 0) return false;
  for (uint8_t i = 0; i < PACKET_COUNT; i++) {
    if (lastBytes[2 + 2 * i] != PACKETS[i]) return false;
  }
  return true;
}

void takeFrame() {
  const uint8_t bumpsAndDrops = lastBytes[3];
  bumped = bumpsAndDrops & BUMPS;
  inDanger = bumpsAndDrops & WHEEL_DROPS;
  for (uint8_t i = 1; i <= LAST_CLIFF; i++) {
    if (lastBytes[3 + 2 * i]) inDanger = true;
  }
  lastFrameMs = millis();
  if (!(lastBytes[3 + 2 * (LAST_CLIFF + 1)] & WHEEL_OVERCURRENTS)) freeMs = lastFrameMs;
  if (lastFrameMs - freeMs > STUCK_MS || lastBytes[3 + 2 * (LAST_CLIFF + 2)] & CLEAN_BUTTON) mustStop = true;
  heard = true;
}

void readRobot() {
  while (Serial.available()) {
    memmove(lastBytes, lastBytes + 1, FRAME_BYTES - 1);
    lastBytes[FRAME_BYTES - 1] = Serial.read();
    if (isFrame()) takeFrame();
  }
}

// Nothing to do until the clock ticks or a byte comes.
void doze() {
  set_sleep_mode(SLEEP_MODE_IDLE);
  sleep_mode();
}

void stopForGood() {
  while (true) {
    stopWheels();
    digitalWrite(LED_BUILTIN, !digitalRead(LED_BUILTIN));
    for (unsigned long since = millis(); millis() - since < 250; ) doze();
  }
}

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

// Reads the robot, and stops where it must not go on.
void guard() {
  readRobot();
  if (inDanger || mustStop || millis() - lastFrameMs > SILENCE_MS) stopForGood();
}

// To be called all the time.
void watch() {
  guard();
  heedSignal();
}

// ---------------------------------------------------------------- moves

// Goes on with what the wheels do for so long, to some microseconds: a millisecond is a tenth of a degree. Counted from
// before the command was given: to hand over its bytes takes as long as to hand over those of the next.
void keepOn(uint32_t beganUs, uint32_t durationUs) {
  uint32_t goneUs;
  while ((goneUs = micros() - beganUs) < durationUs) {
    const uint32_t leftUs = durationUs - goneUs;
    if (leftUs > 1000) watch();  // the last millisecond is for the clock alone
    if (leftUs > 3000) doze();
  }
}

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

void backOff(uint16_t distanceMm) {
  const uint32_t beganUs = micros();
  drive(-BACK_OFF_MM_S, -BACK_OFF_MM_S);
  keepOn(beganUs, distanceMm * 1000000.0 / BACK_OFF_MM_S);
}

// In place; to the left where tenths of a degree are positive.
void turn(int16_t tenths) {
  if (tenths == 0) return;
  const float wayMm = abs(tenths) / 10.0 * DEG_TO_RAD * WHEEL_BASE_MM / 2.0 * TURN_CALIBRATION;
  const int16_t rightMmS = tenths > 0 ? TURN_MM_S : -TURN_MM_S;
  const uint32_t beganUs = micros();
  drive(rightMmS, -rightMmS);
  keepOn(beganUs, wayMm * 1000000.0 / TURN_MM_S);
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

void wake() {
  pinMode(WAKE_PIN, OUTPUT);
  digitalWrite(WAKE_PIN, LOW);
  delay(100);
  digitalWrite(WAKE_PIN, HIGH);
  delay(100);
}

// Asks for the stream until it comes: a robot that boots hears nothing for some seconds.
void startRobot() {
  while (!heard) {
    Serial.write(START);
    delay(20);
    Serial.write(FULL_MODE ? FULL : SAFE);
    delay(20);
    Serial.write(STREAM);
    Serial.write(PACKET_COUNT);
    Serial.write(PACKETS, PACKET_COUNT);
    for (unsigned long since = millis(); millis() - since < 1000 && !heard; ) {
      readRobot();
      doze();
    }
  }
}

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
