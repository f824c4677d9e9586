// A robot's wheels and distance sensor behind the serial protocol of RSRS, docs/serial_protocol.md.
//
// For boards with an AVR, a two-channel motor driver (direction and PWM pins) and an analogue
// distance sensor. What depends on the robot is in the first section and in the four functions at
// the end; the rest is the protocol and should stay as it is.
//
// The wheels stop 250 ms after the last valid command, whatever happened to whoever sent it, and
// the watchdog stops them if this program hangs.

#include <avr/wdt.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

// --- The robot: change these -----------------------------------------------------------------

const char NAME[] = "rsrs_base";
const long BAUD = 115200;

const int LEFT_PWM = 5, LEFT_FORWARD = 7;
const int RIGHT_PWM = 6, RIGHT_FORWARD = 8;
const int RANGE_PIN = A0, BATTERY_PIN = A1;

const long WHEEL_BASE_MM = 120;          // Between the two wheels.
const long FULL_SPEED_MM_S = 350;        // A wheel's speed at full PWM, as measured.
const unsigned FIELD_OF_VIEW_MRAD = 400; // The whole opening angle of the distance sensor.
const unsigned MIN_RANGE_MM = 20, MAX_RANGE_MM = 750;

// --- The protocol ----------------------------------------------------------------------------

const unsigned VERSION = 1;
const unsigned long TIMEOUT_MS = 250;    // The protocol allows no more.
const unsigned long STATE_EVERY_MS = 50;
const size_t LONGEST = 80;

char line[LONGEST + 1];
size_t length = 0;
bool in_line = false;

bool greeted = false;                    // An H has come since power-up.
bool commanded = false;                  // A V has come since the last H.
bool timed_out = true;
uint16_t number = 0;                     // Of the last command.
long speed_mm_s = 0, turn_mrad_s = 0;    // What the wheels are set to now.
unsigned long command_ms = 0, state_ms = 0;

// CRC-16/CCITT-FALSE.
uint16_t crc(const char *text, size_t n) {
  uint16_t sum = 0xFFFF;
  for (size_t i = 0; i < n; i++) {
    sum ^= (uint16_t)(uint8_t)text[i] << 8;
    for (int bit = 0; bit < 8; bit++) {
      sum = (sum & 0x8000) ? (uint16_t)(sum << 1) ^ 0x1021 : (uint16_t)(sum << 1);
    }
  }
  return sum;
}

void send(const char *body) {
  char sum[5];
  snprintf(sum, sizeof sum, "%04X", crc(body, strlen(body)));
  // A computer that does not listen must not stop this loop, and with it the timeout.
  if ((size_t)Serial.availableForWrite() < strlen(body) + 7) return;
  Serial.print('$');
  Serial.print(body);
  Serial.print('*');
  Serial.println(sum);
}

void stop_wheels() {
  speed_mm_s = turn_mrad_s = 0;
  drive_wheels(0, 0);
}

// Reads a whole number and the mark after it; false if there is none, or it is out of range.
bool take(char **rest, char mark, long least, long most, long *value) {
  char *end;
  *value = strtol(*rest, &end, 10);
  if (end == *rest || *end != mark || *value < least || *value > most) return false;
  *rest = end + 1;
  return true;
}

// Reads a time of this clock; its 32 bits do not fit a signed number.
bool take_time(char **rest, uint32_t *value) {
  char *end;
  if (**rest < '0' || **rest > '9') return false;
  *value = (uint32_t)strtoul(*rest, &end, 10);
  if (*end != ',') return false;
  *rest = end + 1;
  return true;
}

// Takes the inside of a line whose checksum is right; its end is a zero.
void on_body(char *body) {
  char *rest = body + 2;
  long version, nonce, new_number, speed, turn;
  uint32_t sent_ms;
  if (strncmp(body, "H,", 2) == 0) {
    if (!take(&rest, ',', 0, 32767, &version) || !take(&rest, 0, 0, 65535, &nonce)) return;
    stop_wheels();
    greeted = version == (long)VERSION;
    commanded = false;
    timed_out = true;
    char answer[LONGEST];
    snprintf(answer, sizeof answer, "I,%u,%lu,%s,%lu,%u,%u,%u", VERSION, (unsigned long)nonce,
             NAME, TIMEOUT_MS, FIELD_OF_VIEW_MRAD, MIN_RANGE_MM, MAX_RANGE_MM);
    send(answer);
  } else if (strncmp(body, "V,", 2) == 0 && greeted) {
    if (!take(&rest, ',', 0, 65535, &new_number) || !take_time(&rest, &sent_ms) ||
        !take(&rest, ',', -30000, 30000, &speed) || !take(&rest, 0, -30000, 30000, &turn)) return;
    // A command that waited somewhere is too old, whoever kept it waiting.
    if ((uint32_t)(millis() - sent_ms) > TIMEOUT_MS) return;
    // The same line received twice does not extend the time.
    if (commanded && (uint16_t)new_number == number) return;
    number = (uint16_t)new_number;
    commanded = true;
    timed_out = false;
    command_ms = millis();
    speed_mm_s = speed;
    turn_mrad_s = turn;
    drive_wheels(speed, turn);
  }
}

// Takes a line from behind its $ up to its end.
void on_line() {
  if (length > 0 && line[length - 1] == '\r') length--;
  if (length < 5 || line[length - 5] != '*') return;
  line[length] = 0;
  char *end;
  unsigned long sum = strtoul(line + length - 4, &end, 16);
  if (end != line + length || sum != crc(line, length - 5)) return;
  line[length - 5] = 0;
  on_body(line);
}

void on_byte(char byte) {
  if (byte == '$') {
    in_line = true;
    length = 0;
  } else if (in_line && byte == '\n') {
    in_line = false;
    on_line();
  } else if (in_line && length < LONGEST) {
    line[length++] = byte;
  } else {
    in_line = false;
  }
}

void send_state() {
  char mode = !greeted ? 'N' : timed_out ? 'T' : 'R';
  char last[7] = "-", range[12] = "-", battery[12] = "-";
  if (commanded) snprintf(last, sizeof last, "%u", number);
  long range_mm = measure_range_mm(), battery_mv = measure_battery_mv();
  if (range_mm >= 0) snprintf(range, sizeof range, "%ld", range_mm);
  if (range_mm == -1) strcpy(range, "i");
  if (battery_mv >= 0) snprintf(battery, sizeof battery, "%ld", battery_mv);
  char body[LONGEST];
  snprintf(body, sizeof body, "S,%lu,%s,%ld,%ld,%c,-,%s,%s",
           (unsigned long)(uint32_t)millis(), last, speed_mm_s,
           turn_mrad_s, mode, range, battery);
  send(body);
}

void setup() {
  pinMode(LEFT_PWM, OUTPUT);
  pinMode(LEFT_FORWARD, OUTPUT);
  pinMode(RIGHT_PWM, OUTPUT);
  pinMode(RIGHT_FORWARD, OUTPUT);
  stop_wheels();
  Serial.begin(BAUD);
  wdt_enable(WDTO_250MS);
}

void loop() {
  wdt_reset();
  // A few bytes at a time: a computer that floods the line does not keep the timeout from running.
  for (int n = 0; n < 32 && Serial.available() > 0; n++) on_byte((char)Serial.read());

  unsigned long now = millis();
  if (!timed_out && now - command_ms >= TIMEOUT_MS) {
    timed_out = true;
    stop_wheels();
  }
  if (now - state_ms >= STATE_EVERY_MS) {
    state_ms = now;
    send_state();
  }
}

// --- The hardware: change these --------------------------------------------------------------

void drive_wheel(int pwm_pin, int forward_pin, long mm_s) {
  long pwm = labs(mm_s) * 255 / FULL_SPEED_MM_S;
  digitalWrite(forward_pin, mm_s >= 0 ? HIGH : LOW);
  analogWrite(pwm_pin, pwm > 255 ? 255 : (int)pwm);
}

// Turns both wheels; counterclockwise is positive. Put a speed control with encoders here if the
// robot has them: the paper's robots do.
void drive_wheels(long mm_s, long mrad_s) {
  long half_difference_mm_s = mrad_s * WHEEL_BASE_MM / 2000;
  drive_wheel(LEFT_PWM, LEFT_FORWARD, mm_s - half_difference_mm_s);
  drive_wheel(RIGHT_PWM, RIGHT_FORWARD, mm_s + half_difference_mm_s);
}

// Distance in mm; -1 for nothing in range. The curve is that of a Sharp GP2Y0A21 at 5 V.
long measure_range_mm() {
  long volts_in_mv = analogRead(RANGE_PIN) * 5000L / 1023;
  if (volts_in_mv < 400) return -1;
  long range_mm = 246000L / (volts_in_mv - 120);
  return range_mm > (long)MAX_RANGE_MM ? -1 : range_mm;
}

// Voltage of the battery in mV behind a divider by two; -2 without one.
long measure_battery_mv() {
  return analogRead(BATTERY_PIN) * 5000L / 1023 * 2;
}
