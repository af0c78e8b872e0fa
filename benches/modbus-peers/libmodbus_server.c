/* libmodbus as the server of many connections: epoll tells which of them has something to say.
   Prints its address, serves 1000 holding and 1000 input registers, ends by itself after five minutes. */
#include <modbus.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/epoll.h>
#include <unistd.h>

#define REGISTERS 1000
#define LIFETIME_S 300
#define EVENTS_MAX 64

static void must(int good, const char *what)
{
    if (!good) {
        perror(what);
        exit(1);
    }
}

static void watch(int epoll, int socket)
{
    struct epoll_event event = {.events = EPOLLIN, .data.fd = socket};
    must(epoll_ctl(epoll, EPOLL_CTL_ADD, socket, &event) == 0, "epoll_ctl");
}

int main(void)
{
    alarm(LIFETIME_S);
    modbus_t *ctx = modbus_new_tcp("127.0.0.1", 0);
    must(ctx != NULL, "modbus_new_tcp");
    modbus_mapping_t *map = modbus_mapping_new(0, 0, REGISTERS, REGISTERS);
    must(map != NULL, "modbus_mapping_new");
    for (int i = 0; i < REGISTERS; i++)
        map->tab_input_registers[i] = (uint16_t)(i * 37);
    int listener = modbus_tcp_listen(ctx, 32);
    must(listener >= 0, "modbus_tcp_listen");
    struct sockaddr_in address;
    socklen_t size = sizeof address;
    must(getsockname(listener, (struct sockaddr *)&address, &size) == 0, "getsockname");
    printf("127.0.0.1:%d\n", ntohs(address.sin_port));
    fflush(stdout);

    int epoll = epoll_create1(0);
    must(epoll >= 0, "epoll_create1");
    watch(epoll, listener);
    for (;;) {
        struct epoll_event events[EVENTS_MAX];
        int count = epoll_wait(epoll, events, EVENTS_MAX, -1);
        for (int i = 0; i < count; i++) {
            int socket = events[i].data.fd;
            if (socket == listener) {
                int on = 1;
                socket = modbus_tcp_accept(ctx, &listener);
                must(socket >= 0, "modbus_tcp_accept");
                setsockopt(socket, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
                watch(epoll, socket);
                continue;
            }
            uint8_t request[MODBUS_TCP_MAX_ADU_LENGTH];
            modbus_set_socket(ctx, socket);
            int length = modbus_receive(ctx, request);
            if (length > 0)
                modbus_reply(ctx, request, length, map);
            else if (length < 0)
                close(socket);
        }
    }
}
