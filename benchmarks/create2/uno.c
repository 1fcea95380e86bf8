/* An Arduino Uno in simavr, its serial port on stdin and stdout, in the simulated time of its own clock.
 *
 * Usage: uno FIRMWARE.elf [RATE]. RATE: of its clock, 1 by default; microseconds below are those of a clock that is right.
 * Each request: a uint32 of microseconds to run, a uint8 that draws pin 3 to ground unless it is 0, a uint8 n, n bytes
 * that the Uno receives from the beginning of that time on. Each answer: a uint16 m, then m times a uint32 (when, in microseconds since the
 * beginning of that time) and the byte that the Uno sent. Native byte order. Ends with its input; code 2 on a crash.
 */
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <simavr/avr_ioport.h>
#include <simavr/avr_uart.h>
#include <simavr/sim_avr.h>
#include <simavr/sim_elf.h>

enum { FREQUENCY_HZ = 16000000, CYCLES_PER_US = FREQUENCY_HZ / 1000000, MOST_SENT = 4096, TCCR1B = 0x81, TCCR2B = 0xB1 };

struct __attribute__((packed)) sent {
  uint32_t at_us;
  uint8_t byte;
};

static avr_t *avr;
static avr_cycle_count_t began;
static struct sent sent[MOST_SENT];
static uint16_t sent_count;
static double cycles_per_us = CYCLES_PER_US;

static void on_sent(struct avr_irq_t *irq, uint32_t value, void *param) {
  (void)irq, (void)param;
  if (sent_count < MOST_SENT) {
    sent[sent_count].at_us = (uint32_t)((avr->cycle - began) / cycles_per_us);
    sent[sent_count++].byte = (uint8_t)value;
  }
}

/* simavr would let the host sleep as long as the chip does: there is no need to. */
static void no_sleep(avr_t *chip, avr_cycle_count_t cycles) { (void)chip, (void)cycles; }

static void store(avr_io_addr_t address, uint8_t value) {
  avr_io_addr_t io = AVR_DATA_TO_IO(address);
  if (avr->io[io].w.c) avr->io[io].w.c(avr, address, value, avr->io[io].w.param);
}

/* The Arduino core lets timers 1 and 2 run for pulse-width modulation, which no sketch here uses; in simavr they give an
 * event every 64 cycles, and that takes most of its time. */
static void stop_idle_timers(void) {
  store(TCCR1B, 0);
  store(TCCR2B, 0);
}

int main(int argc, char **argv) {
  FILE *answers = fdopen(dup(STDOUT_FILENO), "wb");
  if (!answers || !freopen("/dev/null", "w", stdout)) return 1; /* where simavr writes what it thinks */
  elf_firmware_t firmware;
  memset(&firmware, 0, sizeof(firmware));
  if (argc > 2) cycles_per_us *= atof(argv[2]);
  if (argc < 2 || argc > 3 || elf_read_firmware(argv[1], &firmware)) return 1;
  avr = avr_make_mcu_by_name("atmega328p");
  if (!avr) return 1;
  avr_init(avr);
  avr->log = LOG_NONE;
  firmware.frequency = FREQUENCY_HZ;
  avr_load_firmware(avr, &firmware);
  avr->frequency = FREQUENCY_HZ;
  avr->sleep = no_sleep;
  uint32_t flags = 0; /* neither echoed to the terminal nor slowed down while the program polls */
  avr_ioctl(avr, AVR_IOCTL_UART_SET_FLAGS('0'), &flags);
  avr_irq_t *input = avr_io_getirq(avr, AVR_IOCTL_UART_GETIRQ('0'), UART_IRQ_INPUT);
  avr_irq_register_notify(avr_io_getirq(avr, AVR_IOCTL_UART_GETIRQ('0'), UART_IRQ_OUTPUT), on_sent, NULL);

  avr_irq_t *pin = avr_io_getirq(avr, AVR_IOCTL_IOPORT_GETIRQ('D'), 3);

  uint32_t run_us;
  uint8_t grounded, count, bytes[255];
  avr_cycle_count_t until = 0;
  while (fread(&run_us, sizeof(run_us), 1, stdin) == 1 && fread(&grounded, 1, 1, stdin) == 1 &&
         fread(&count, 1, 1, stdin) == 1) {
    if (fread(bytes, 1, count, stdin) != count) break;
    began = until;
    if (began) stop_idle_timers(); /* the core has started them in the first of all times */
    until += (avr_cycle_count_t)(run_us * cycles_per_us);
    avr_raise_irq(pin, !grounded);
    sent_count = 0;
    for (uint8_t k = 0; k < count; k++) avr_raise_irq(input, bytes[k]);
    while (avr->cycle < until) {
      int state = avr_run(avr);
      if (state == cpu_Done || state == cpu_Crashed) return 2;
    }
    fwrite(&sent_count, sizeof(sent_count), 1, answers);
    fwrite(sent, sizeof(sent[0]), sent_count, answers);
    fflush(answers);
  }
  return 0;
}
