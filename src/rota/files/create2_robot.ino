// Wiring, Create 2 mini-DIN socket -> Arduino Uno:
//   pin 3  RXD            -> pin 1 (TX)
//   pin 4  TXD            -> pin 0 (RX)
//   pin 5  BRC            -> pin 2 (WAKE_PIN below)
//   pin 6 or 7  ground    -> GND
//   a button or receiver for all robots -> pin 3, to ground, where the sketch has a SIGNAL_PIN; may be left out
//   pin 1 or 2  battery   -> 9 V regulator -> VIN; never straight to the Arduino: it is up to 20 V
// Unplug pins 0 and 1 while you upload. The LED on the Arduino is lit while all is well and blinks after a stop.
//
// It stops for good over a cliff, when it is lifted, when its wheels are stuck, when CLEAN is pressed on the robot,
// when the robot falls silent, and when it is lost.

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
const unsigned long STUCK_MS = 500;  // for so long too much current for a wheel

const int16_t BACK_OFF_MM_S = @BACK_OFF_MM_S@;  // speed while backing off
const int16_t TURN_MM_S = @TURN_MM_S@;      // speed of each wheel while turning in place
const float WHEEL_BASE_MM = 235.0;    // from wheel to wheel

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

// Reads the robot, and stops where it must not go on.
void guard() {
  readRobot();
  if (inDanger || mustStop || millis() - lastFrameMs > SILENCE_MS) stopForGood();
}

void watch();  // guard, and whatever else is to be done all the time

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
