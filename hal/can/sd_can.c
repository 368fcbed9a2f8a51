/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE /* sendmmsg */
#include "sd_can.h"

#include <errno.h>
#include <linux/can.h>
#include <linux/can/raw.h>
#include <net/if.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <unistd.h>

enum { FRAMES_AT_ONCE = 32, FRAMES_A_READ = 4096 }; /* so that no flood of foreign frames keeps a reader for ever */

static int configure(int fd, const char *interface, sd_role_t role) {
    struct ifreq request = { .ifr_mtu = 0 };
    if (strlen(interface) >= sizeof request.ifr_name) { return ENODEV; }
    strcpy(request.ifr_name, interface);
    if (ioctl(fd, SIOCGIFMTU, &request) != 0) { return errno; }
    if (request.ifr_mtu < (int)CANFD_MTU) { return EMSGSIZE; }
    const int on = 1;
    if (setsockopt(fd, SOL_CAN_RAW, CAN_RAW_FD_FRAMES, &on, sizeof on) != 0) { return errno; }
    /* What an ecu must not know does not reach its socket. */
    const struct can_filter no_truth = { .can_id = SD_CAN_TRUTH_FIRST | CAN_INV_FILTER, .can_mask = CAN_SFF_MASK & ~3u };
    if ((role == SD_ROLE_ECU) && (setsockopt(fd, SOL_CAN_RAW, CAN_RAW_FILTER, &no_truth, sizeof no_truth) != 0)) { return errno; }
    /* Room for a reader that is some seconds late. Beyond the system's limit only root gets it. */
    const int room = 1 << 23;
    if (setsockopt(fd, SOL_SOCKET, SO_RCVBUFFORCE, &room, sizeof room) != 0) {
        (void)setsockopt(fd, SOL_SOCKET, SO_RCVBUF, &room, sizeof room);
    }
    struct sockaddr_can address = { .can_family = AF_CAN, .can_ifindex = (int)if_nametoindex(interface) };
    return (bind(fd, (struct sockaddr *)&address, sizeof address) == 0) ? 0 : errno;
}

int sd_can_open(sd_can_t *self, const char *interface, sd_role_t role, uint16_t session) {
    memset(self, 0, sizeof *self);
    self->codec.role = role;
    self->codec.session = session;
    self->fd = socket(PF_CAN, SOCK_RAW | SOCK_NONBLOCK | SOCK_CLOEXEC, CAN_RAW);
    if (self->fd < 0) { return errno; }
    const int error = configure(self->fd, interface, role);
    if (error != 0) { sd_can_close(self); }
    return error;
}

void sd_can_close(sd_can_t *self) {
    if (self->fd >= 0) { (void)close(self->fd); }
    self->fd = -1;
}

/* ---- out ------------------------------------------------------------------------------------------------------- */

int sd_can_flush(sd_can_t *self) {
    sd_can_codec_t *codec = &self->codec;
    while (codec->read != codec->written) {
        struct canfd_frame raw[FRAMES_AT_ONCE];
        struct iovec part[FRAMES_AT_ONCE];
        struct mmsghdr message[FRAMES_AT_ONCE];
        memset(raw, 0, sizeof raw);
        memset(message, 0, sizeof message);
        unsigned count = 0;
        for (; (count < FRAMES_AT_ONCE) && (codec->read + count != codec->written); ++count) {
            const sd_frame_t *frame = &codec->out[(codec->read + count) % SD_CAN_FRAMES];
            raw[count].can_id = frame->id;
            raw[count].len = frame->length;
            memcpy(raw[count].data, frame->bytes, frame->length);
            part[count] = (struct iovec){ &raw[count], frame->fd ? CANFD_MTU : CAN_MTU };
            message[count].msg_hdr.msg_iov = &part[count];
            message[count].msg_hdr.msg_iovlen = 1;
        }
        const int sent = sendmmsg(self->fd, message, count, MSG_DONTWAIT);
        if (sent > 0) {
            codec->read += (uint32_t)sent;
            codec->counts.sent += (uint32_t)sent;
        } else if ((errno == EAGAIN) || (errno == ENOBUFS) || (errno == EINTR)) {
            return 0; /* full: later */
        } else {
            codec->counts.unsent += codec->written - codec->read; /* down: a late frame would be a wrong one */
            codec->read = codec->written;
        }
    }
    return 1;
}

static uint32_t send_events(void *context, const sd_event_t *events, uint32_t count) {
    sd_can_t *self = context;
    uint32_t taken = 0;
    while (taken < count) {
        if (!sd_can_encode(&self->codec, &events[taken])) {
            (void)sd_can_flush(self);
            if (!sd_can_encode(&self->codec, &events[taken])) { break; }
        }
        taken++;
    }
    const uint16_t last = (count > 0u) ? events[count - 1u].kind : 0u;
    if ((last == SD_EVENT_TIME) || (last == SD_EVENT_DONE) || (last == SD_EVENT_PARAMETER)) { (void)sd_can_flush(self); }
    return taken;
}

/* ---- in -------------------------------------------------------------------------------------------------------- */

int sd_can_read(sd_can_t *self) {
    for (int frames = 0; frames < FRAMES_A_READ; ++frames) {
        struct canfd_frame raw;
        const ssize_t size = recv(self->fd, &raw, sizeof raw, MSG_DONTWAIT);
        if (size <= 0) { return 0; } /* nothing there, or the interface is down */
        if ((size != (ssize_t)CAN_MTU) && (size != (ssize_t)CANFD_MTU)) { continue; }
        sd_frame_t frame = { .id = raw.can_id, .fd = size == (ssize_t)CANFD_MTU, .length = raw.len };
        if (frame.length > sizeof frame.bytes) { continue; }
        memcpy(frame.bytes, raw.data, frame.length);
        if (sd_can_decode(&self->codec, &frame)) { return 1; }
        if (self->codec.in.written - self->codec.in.read > SD_QUEUE_EVENTS / 2u) { return 0; }
    }
    return 0;
}

static uint32_t receive_events(void *context, sd_event_t *events, uint32_t room) {
    sd_can_t *self = context;
    /* A tool reads by itself, since it wants the truth too. */
    if ((self->codec.role != SD_ROLE_TOOL) && (self->codec.in.read == self->codec.in.written)) { (void)sd_can_read(self); }
    return sd_queue_take(&self->codec.in, events, room);
}

int sd_can_wait(sd_can_t *self, int milliseconds) {
    if (self->codec.in.read != self->codec.in.written) { return 1; }
    const short want = (short)(POLLIN | ((self->codec.read != self->codec.written) ? POLLOUT : 0));
    struct pollfd source = { .fd = self->fd, .events = want };
    (void)poll(&source, 1, milliseconds);
    (void)sd_can_flush(self);
    return (source.revents & POLLIN) != 0;
}

sd_port_t sd_can_port(sd_can_t *self) { return (sd_port_t){ self, receive_events, send_events }; }
