#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""A table of signals with 32 inputs: what is generated from it carries all of them over CAN and LCM; a 33rd is refused."""
import pathlib
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.append(str(ROOT / "tools" / "signals"))
import bus_code
import generate

INPUT = '\n[[input]]\nname = "spare.sensor_{}"\nunit = "bar"\nrange = [0, 40]\nage = 0.1\nusual = 1\ntext = "Of this test."\n'
OWNER = '\n[[owner]]\nname = "spare"\ntext = "Of this test."\ninvalid_without = ["spare.sensor_{}"]\n'
MAIN = """
#include <assert.h>
#include "sd_can_codec.h"
#include "sd_lcm_codec.h"

static sd_can_codec_t plant, ecu;
static sd_lcm_codec_t lcm_ecu;

static sd_event_t sample(uint32_t input) {
    const float value = 0.5f + (float)input;
    sd_event_t event = { .tick = 0xfffffff0u + input, .kind = SD_EVENT_SAMPLE, .channel = (uint16_t)input };
    memcpy(&event.value, &value, sizeof value);
    return event;
}

static void check(sd_queue_t *queue) {
    for (uint32_t input = 0; input < SD_INPUT_COUNT; ++input) {
        sd_event_t got, sent = sample(input);
        assert(sd_queue_take(queue, &got, 1) == 1 && memcmp(&got, &sent, sizeof got) == 0);
    }
    assert(queue->read == queue->written);
}

int main(void) {
    sixdeg_event_t events[SD_INPUT_COUNT];
    sixdeg_inputs_t m = { SD_INPUT_COUNT, 0, 1, events };
    uint8_t bytes[4096];
    assert(SD_INPUT_COUNT == 32u && sd_owner_infos[SD_OWNER_SPARE].invalid_without == 1u << 31);
    assert(sd_input_infos[31].usual == 1.0f && sd_input_infos[31].age_s == 0.1f);
    plant.role = SD_ROLE_PLANT;
    for (uint32_t input = 0; input < SD_INPUT_COUNT; ++input) {
        const sd_event_t event = sample(input);
        assert(sd_can_encode(&plant, &event) == 1);
        events[input] = (sixdeg_event_t){ (int32_t)event.tick, (int16_t)event.kind, (int16_t)event.channel, (int32_t)event.value, 0 };
    }
    while (plant.read != plant.written) { sd_can_decode(&ecu, &plant.out[plant.read++ % SD_CAN_FRAMES]); }
    assert(ecu.counts.foreign + ecu.counts.malformed == 0u && ecu.counts.received == SD_INPUT_COUNT);
    check(&ecu.in);
    sd_lcm_decode(&lcm_ecu, SD_LCM_INPUTS, bytes, sixdeg_inputs_t_encode(bytes, 0, sizeof bytes, &m));
    assert(lcm_ecu.counts.malformed == 0u);
    check(&lcm_ecu.in);
    return 0;
}
"""


def table(folder, count):
    text = generate.TABLE.read_text()
    spare = count - len(generate.load()["input"])
    path = folder / "signals.toml"
    path.write_text(text + "".join(INPUT.format(i + 1) for i in range(spare)) + OWNER.format(spare))
    return path


with tempfile.TemporaryDirectory() as temporary:
    folder = pathlib.Path(temporary)
    try:
        generate.load(table(folder, 33))
        sys.exit("33 inputs were taken")
    except AssertionError as error:
        assert "33 inputs; there is room for 32" in str(error), error
    generated = folder / "generated"
    for kind in ("can", "lcm"):
        (generated / kind).mkdir(parents=True)
    for name, text in generate.generated(table(folder, 32)).items():
        (generated / name).write_text(text)
    (folder / "scratch").mkdir()
    for name, text in bus_code.fresh(folder / "scratch", generated).items():
        (generated / name).write_text(text)
    (folder / "main.c").write_text(MAIN)
    lcm = subprocess.run(["pkg-config", "--cflags", "--libs", "lcm"], capture_output=True, text=True, check=True).stdout.split()
    paths = ["-I" + str(path) for path in [generated, generated / "can", generated / "lcm"] +
             [ROOT / "hal" / part for part in ("", "wire", "can", "lcm")]]
    sources = [folder / "main.c", generated / "sd_signals.c", ROOT / "hal/wire/sd_row.c", ROOT / "hal/can/sd_can_codec.c",
               ROOT / "hal/lcm/sd_lcm_codec.c", *generated.glob("can/*.c"), *generated.glob("lcm/*.c")]
    subprocess.run(["cc", "-std=gnu11", "-O1", *paths, *map(str, sources), *lcm, "-lm", "-o", folder / "wide"], check=True)
    subprocess.run([folder / "wide"], check=True)
