// @TITLE@
//
// An iRobot Create 2 that drives straight until it bumps, and turns by one angle to the left; that is all. The program
// of Alam & Bobadilla 2020: no plan, no clock, no table. Written by Rota, for an Arduino Uno.
//
// Turns:   @ANGLE@ degrees at every bump
// Covers:  @COVERS@
//
@ROBOT@
// ---------------------------------------------------------------- what it does

const int16_t SPEED_MM_S = @SPEED_MM_S@;      // forward
const int16_t ANGLE_TENTHS = @ANGLE_TENTHS@;    // of a degree, to the left where above 0
const uint16_t BACK_OFF_MM = 10;      // so that the bumper comes free
const uint32_t LONGEST_MS = @LONGEST_MS@;  // no way between two walls takes longer: a door is open

const unsigned long HANDS_OFF_MS = 3000;  // from its first answer on

void watch() {
  guard();
}

void setup() {
  pinMode(LED_BUILTIN, OUTPUT);
  Serial.begin(BAUD);
  wake();
  startRobot();
  digitalWrite(LED_BUILTIN, HIGH);
  for (unsigned long since = millis(); millis() - since < HANDS_OFF_MS; ) {
    watch();
    doze();
  }
}

void loop() {
  const unsigned long beganMs = millis();
  drive(SPEED_MM_S, SPEED_MM_S);
  while (!bumped) {
    watch();
    if (millis() - beganMs > LONGEST_MS) stopForGood();
    doze();
  }
  backOff(BACK_OFF_MM);
  turn(ANGLE_TENTHS);
}
