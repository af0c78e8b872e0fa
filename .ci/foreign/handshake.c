/* A PLC program as others write one, with libmodbus: the handshake as the manuals have it, or with one usual mistake.
 *
 * Usage: handshake PORT right|together|torn|changed|dropped|kept|hasty|unchecked|backwards
 *
 * It programs the encoder at position 0. handshake.py is the same with pymodbus. */
#include <errno.h>
#include <modbus.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

static modbus_t *client;

static void check(int answered, const char *what) {
    if (answered < 0) {
        fprintf(stderr, "%s: %s\n", what, modbus_strerror(errno));
        exit(1);
    }
}

static void pause_ms(long ms) {
    struct timespec time = {ms / 1000, ms % 1000 * 1000000};
    nanosleep(&time, NULL);
}

static void put(uint32_t word) {
    uint16_t halves[2] = {word >> 16, word & 0xFFFF};
    check(modbus_write_registers(client, 0, 2, halves), "write");
}

static void put_half(int place, uint16_t value) {
    check(modbus_write_register(client, place, value), "write of a half");
}

static void until(int bit) {
    time_t began = time(NULL);
    uint16_t halves[2];
    do {
        check(modbus_read_input_registers(client, 0, 2, halves), "read");
        if (halves[0] >> 15 == bit) return;
    } while (time(NULL) - began < 30);
    fprintf(stderr, "waited 30 s for IN bit 31 = %d\n", bit);
    exit(1);
}

static void end(uint32_t request) {
    until(1);
    put(request & 0x7FFFFFFF);
    until(0);
}

/* Data and number first, the service bit in a later cycle; then the reply, then the end. */
static void service(uint32_t request) {
    put(request & 0x7FFFFFFF);
    pause_ms(20);
    put(request);
    end(request);
}

static void right(void) {
    service(0xC200270F);
    service(0xC300000A);
    service(0xC9000001);
    service(0x88000000);
    service(0xC6000005);
    service(0x82000000);
}

static void together(void) {
    put(0xC200270F);
    end(0xC200270F);
    service(0x88000000);
}

static void torn(void) {
    put_half(0, 0xC600);
    put_half(1, 0x0005);
    end(0xC6000005);
}

static void changed(void) {
    put(0x46000005);
    pause_ms(100);
    put(0xC6000005);
    put(0xC6000006);
    end(0xC6000005);
}

static void dropped(void) {
    put(0x46000005);
    pause_ms(100);
    put(0xC6000005);
    put(0x46000005);
    pause_ms(500);
}

static void kept(void) {
    put(0x46000005);
    pause_ms(20);
    put(0xC6000005);
    until(1);
    pause_ms(1500);
}

static void hasty(void) {
    put(0x02000000);
    pause_ms(100);
    put(0x82000000);
    until(1);
    put(0x03000000);
    put(0x83000000);
    pause_ms(500);
    put(0x03000000);
    until(0);
}

static void unchecked(void) {
    service(0xC200270F);
    service(0xC6000005);
}

static void backwards(void) {
    service(0xC8000000);
    service(0x88000000);
}

static const struct {
    const char *name;
    void (*run)(void);
} PROGRAMS[] = {{"right", right},     {"together", together}, {"torn", torn},
                {"changed", changed}, {"dropped", dropped},   {"kept", kept},
                {"hasty", hasty},     {"unchecked", unchecked}, {"backwards", backwards}};

int main(int count, char **arguments) {
    if (count != 3) return 2;
    client = modbus_new_tcp("127.0.0.1", atoi(arguments[1]));
    check(client && modbus_connect(client) == 0 ? 0 : -1, "connect");
    for (size_t k = 0; k < sizeof PROGRAMS / sizeof *PROGRAMS; k++) {
        if (strcmp(PROGRAMS[k].name, arguments[2]) == 0) {
            PROGRAMS[k].run();
            modbus_close(client);
            return 0;
        }
    }
    fprintf(stderr, "no program %s\n", arguments[2]);
    return 2;
}
