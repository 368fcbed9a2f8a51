// SPDX-License-Identifier: MIT
// The calibration page, and what it says of an engine.
#include <array>
#include <cmath>
#include <cstring>
#include <gtest/gtest.h>
#include <map>
#include <memory>
#include <tuple>

#include "common/error.hpp"
#include "support/ecu_on_wire.hpp"
#include "support/torque_signal.hpp"

using namespace sixdeg;
using namespace sixdeg::test;

namespace {

TEST(CalibrationPage, ComesBackAsItWasAndIsRefusedWhenTouched) {
    const sd_calibration_t original = page("[torque]\nharmonics = 7\ngain_energy = 4.0\n");
    auto bytes = page_bytes(original);
    const auto back = read_page({reinterpret_cast<const char *>(bytes.data()), bytes.size()});
    ASSERT_TRUE(back);
    EXPECT_EQ(bytes, page_bytes(*back));
    EXPECT_EQ(7.0f, back->parameters.torque_harmonics);
    std::vector<std::uint32_t> words((bytes.size() + 3) / 4 + 1);
    auto *lying = reinterpret_cast<std::uint8_t *>(words.data());
    std::memcpy(lying, bytes.data(), bytes.size());
    const auto size = std::uint32_t(bytes.size());
    ASSERT_EQ(lying, reinterpret_cast<const std::uint8_t *>(sd_calibration_view(lying, size))) << "read where it lies";
    for (std::size_t i = 0; i < bytes.size(); i += 97) {
        lying[i] ^= 0x10;
        ASSERT_EQ(nullptr, sd_calibration_view(lying, size)) << i;
        lying[i] ^= 0x10;
    }
    for (std::uint32_t less = 0; less < size; less += 13) ASSERT_EQ(nullptr, sd_calibration_view(lying, less));
    std::memmove(lying + 1, lying, bytes.size());
    EXPECT_EQ(nullptr, sd_calibration_view(lying + 1, size)) << "not aligned";
}

TEST(CalibrationPage, OfTheOtherByteOrderIsRefused) {
    const auto bytes = page_bytes(page());
    std::vector<std::uint32_t> words(bytes.size() / 4);
    std::memcpy(words.data(), bytes.data(), 4 * words.size());
    for (std::uint32_t &word : words) word = __builtin_bswap32(word);
    EXPECT_EQ(nullptr, sd_calibration_view(words.data(), std::uint32_t(bytes.size())));
}

TEST(CalibrationPage, IsReadInPlaceWithoutItsUnusedTail) {
    // StoredPage holds no byte beyond the used pool, and the sanitizers watch: the ecu runs from it.
    EXPECT_LT(sd_calibration_bytes(&page()), sizeof(sd_calibration_t));
    Ecu ecu(page());
    EXPECT_EQ(page_bytes(page()).size(), ecu.page.view()->head.bytes);
}

TEST(CalibrationPage, BytesHaveAFixedOrder) {
    const auto bytes = page_bytes(page());
    ASSERT_GT(bytes.size(), 16u);
    EXPECT_EQ('S', bytes[0]);
    EXPECT_EQ(bytes.size(), std::size_t(bytes[4] | bytes[5] << 8));
    float tick_hz;
    std::memcpy(&tick_hz, &bytes[20], 4);
    EXPECT_EQ(1e7f, tick_hz);
    EXPECT_EQ(60, bytes[31]) << "positions";
}

double inertia_kgm2(const sd_calibration_t &c, int k) {
    return double(c.fourier.inertia_base_kgm2) * double(c.fourier.inertia_q31[k]) / 2147483648.0;
}

TEST(Calibration, AnglesLandOnTheRightPositions) {
    // diesel_22.toml: position 0 at 270 deg; firing TDC 0, 180, 360, 540; missing at 258 and 264 deg (document 004).
    const sd_calibration_t c = page();
    const int expected[] = {75, 105, 15, 45};
    for (int i = 0; i < 4; ++i) EXPECT_EQ(expected[i], c.firing_position[i]) << i;
    EXPECT_EQ(25, c.cam_position); // 420 deg
    // J half a pitch before position 15, a TDC: 3 deg before it the arm is almost nothing.
    EXPECT_NEAR(0.25, inertia_kgm2(c, 15), 1e-4);
    const TorqueSignal independent;
    for (int k = 0; k < 60; ++k) {
        EXPECT_NEAR(independent.inertia((270 + 6 * (k - 0.5)) * M_PI / 180), inertia_kgm2(c, k), 1e-7);
    }
}

TEST(Calibration, RefusesGainsThatDoNotConvergeEvenBelowTheRule) {
    TomlFile tune("t.toml", "[torque]\nharmonics = 12\ngain_energy = 1.0\ngain_reference = 2.0\n");
    const sd_parameters_t parameters = read_tune(tune);
    try {
        calibrate(diesel(), parameters, "t.toml");
        FAIL() << "accepted";
    } catch (const InputError &error) {
        EXPECT_NE(std::string(error.what()).find("t.toml: torque.gain_energy"), std::string::npos) << error.what();
        EXPECT_NE(std::string(error.what()).find("allowed below 1"), std::string::npos) << error.what();
    }
}

TEST(LearnedPage, ComesBackAsItWasAndIsRefusedWhenTouchedOrOlder) {
    sd_kept_t kept{};
    kept.pattern.cycles = 7;
    kept.mixture = {{0.003f, 0.001f, 0.1f, 0.05f}, 0.01f, 0.03f, 0.015f};
    sd_learned_t page{};
    sd_learned_make(&page, &kept);
    const sd_kept_t *view = sd_learned_view(&page, sizeof page);
    ASSERT_NE(nullptr, view);
    EXPECT_EQ(0, std::memcmp(&kept, view, sizeof kept));
    for (std::size_t i = 0; i < sizeof page; i += 61) {
        reinterpret_cast<std::uint8_t *>(&page)[i] ^= 0x10;
        EXPECT_EQ(nullptr, sd_learned_view(&page, sizeof page)) << i;
        reinterpret_cast<std::uint8_t *>(&page)[i] ^= 0x10;
    }
    EXPECT_EQ(nullptr, sd_learned_view(&page, sizeof page - 4));
    sd_page_seal(&page.head, 0x354c4453u, sizeof page); // SDL5
    EXPECT_EQ(nullptr, sd_learned_view(&page, sizeof page));
}

/// A part that does not fit leaves the other one alone.
TEST(LearnedPage, IsTakenUpAsAWholeOrNotAtAll) {
    Ecu ecu(page());
    sd_kept_t kept;
    sd_ecu_keep(ecu.ecu.get(), ecu.page.view(), &kept);
    const auto resumes = [&](auto spoil) {
        sd_kept_t other = kept;
        other.mixture.learned = {0.003f, 0.001f, 0, 0.2f};
        spoil(other);
        return sd_ecu_resume(ecu.ecu.get(), ecu.page.view(), &other) == SD_OK;
    };
    EXPECT_FALSE(resumes([](sd_kept_t &k) { k.pattern.late[3] = NAN; }));
    EXPECT_EQ(0, ecu.ecu->mixture.delay.learned.late_s);
    EXPECT_FALSE(resumes([](sd_kept_t &k) { k.mixture.dead_s = 1; }));
    EXPECT_EQ(0, ecu.ecu->mixture.delay.learned.late_s);
    EXPECT_TRUE(resumes([](sd_kept_t &) {}));
    EXPECT_FLOAT_EQ(0.003f, ecu.ecu->mixture.delay.learned.late_s);
    EXPECT_FLOAT_EQ(0.003f, ecu.ecu->mixture.afr.known.late_s) << "before the first cycle";
}

} // namespace
