/* SPDX-License-Identifier: MIT */
#include "sd_airpath_point.h"

#define CALM_SPEED 0.05f
#define CALM_FUEL  0.10f
#define LEFT_SPEED 0.12f
#define LEFT_FUEL  0.25f

static bool near_to(float x, float middle, float share) {
    const float off = x - middle;
    return (off <= share * middle) && (off >= -share * middle);
}

bool sd_airpath_point_step(sd_airpath_point_t *self, float period_s, float speed_rpm, float fuel_gps) {
    if (self->speed_rpm <= 0.0f) { /* the first one is as good as an average */
        self->speed_rpm = speed_rpm;
        self->fuel_gps = fuel_gps;
    }
    const float share = period_s / SD_AIRPATH_POINT_MEAN_S;
    self->speed_rpm += share * (speed_rpm - self->speed_rpm);
    self->fuel_gps += share * (fuel_gps - self->fuel_gps);
    self->calm_steps += (self->calm_steps < UINT32_MAX) ? 1u : 0u;
    if (!near_to(speed_rpm, self->speed_rpm, CALM_SPEED) || !near_to(fuel_gps, self->fuel_gps, CALM_FUEL)) { self->calm_steps = 0; }
    return (float)self->calm_steps * period_s >= SD_AIRPATH_POINT_CALM_S;
}

void sd_airpath_point_keep(sd_airpath_point_t *self) {
    self->kept_speed_rpm = self->speed_rpm;
    self->kept_fuel_gps = self->fuel_gps;
}

bool sd_airpath_point_left(const sd_airpath_point_t *self) {
    return (self->kept_speed_rpm > 0.0f) &&
           (!near_to(self->speed_rpm, self->kept_speed_rpm, LEFT_SPEED) || !near_to(self->fuel_gps, self->kept_fuel_gps, LEFT_FUEL));
}
