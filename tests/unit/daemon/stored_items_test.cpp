/// SensorKeeper: which stored measurements it uses after a restart, and with another LUT.
#include <gtest/gtest.h>

#include <algorithm>

#include "daemon/ovwsd/layout/mode_operators.hpp"
#include "tests/unit/daemon/keeper_bench.hpp"

namespace ovws {
namespace {

namespace fs = std::filesystem;

class StoredItems : public test::Keeper {
 protected:
  StoredItems() {
    start_with([](Config& config) { config.tracking.tracker = TrackerKind::lg; });
  }

  void start_with(const std::function<void(Config&)>& change) {
    end();
    change(config_);
    start();
  }
  /// Stores a reference, and a calibration by the model's slopes.
  void measure() {
    ASSERT_TRUE(edit([](SensorEdit& edit) -> Result<void> {
      SpotAverage given;
      given.frames = 1;
      given.mean_px = model_positions(edit.state, edit.bench.optics);
      given.standard_error_px.assign(given.mean_px.size(), {0.01, 0.01});
      given.found.assign(given.mean_px.size(), 1);
      return use_given_reference(given)(edit);
    }));
    ASSERT_TRUE(edit([](SensorEdit& edit) -> Result<void> {
      const SensorState& state = edit.state;
      const ModeOperator model =
          slope_operator(state.renderer->lattice(), state.sensor, state.tracking,
                         px_per_cycle(optics_of(state, edit.bench.optics), edit.bench.optics.slm));
      MeasuredCalibration measured;
      measured.amplitude_waves = 0.15;
      measured.frames = 20;
      measured.t_taken_ns = 5;
      measured.matrix.modes_j = model.modes_j;
      measured.matrix.amplitude_waves.assign(model.modes_j.size(), 0.15);
      measured.matrix.slopes = model.slopes.cast<float>().cast<double>();
      measured.matrix.standard_error.setConstant(model.slopes.rows(), model.slopes.cols(), 0.125);
      return use_calibration(state.sensor_epoch, measured)(edit);
    }));
  }
  bool has_both() const {
    const SensorView now = keeper_->snapshot();
    return now->reference && now->calibration;
  }
  bool has_none() const {
    const SensorView now = keeper_->snapshot();
    return !now->reference && !now->calibration;
  }
  std::size_t loaded(const std::string& words) {
    const auto wanted = [&](const EventMessage& event) {
      return (event.kind == "reference" || event.kind == "calibration") &&
             event.text.find(words) != std::string::npos;
    };
    return events_where(wanted).size();
  }
  static MeasuredLut other_lut() {
    MeasuredLut lut;
    lut.t_taken_ns = 5;
    lut.frames = 3;
    lut.response.levels = 33;
    for (std::size_t g = 0; g < 256; ++g) lut.response.phase_rad[g] = 7.0 * double(g) / 255.0;
    lut.table = linearising_lut(lut.response.phase_rad);
    return lut;
  }
};

TEST_F(StoredItems, AreUsedByTheSameBenchAndOnlyByIt) {
  measure();
  ASSERT_TRUE(has_both());
  start_with([](Config& config) { config.optics.wavelength_nm = 633.0; });
  EXPECT_TRUE(has_none());
  EXPECT_EQ(loaded("is not used: optics.wavelength_nm was 632.0, and is 633.0"), 2U);
  start_with([](Config& config) { config.optics.wavelength_nm = 632.0; });
  EXPECT_TRUE(has_both());
  EXPECT_EQ(loaded("is loaded"), 2U);
  EXPECT_EQ(keeper_->snapshot()->calibration->comparison.disagreement, Disagreement::none);
}

TEST_F(StoredItems, OfAnotherLutAreUsedWhenItIsAsItWas) {
  measure();
  ASSERT_TRUE(edit(use_lut(other_lut())));
  EXPECT_TRUE(has_none());
  EXPECT_NE(keeper_->snapshot()->obstacle.reason.find("another look-up table"), std::string::npos);
  ASSERT_TRUE(edit(forget_lut()));
  EXPECT_TRUE(has_both()) << "in the same run";
  ASSERT_TRUE(edit(use_lut(other_lut())));
  start_with([](Config&) {});
  EXPECT_TRUE(keeper_->snapshot()->slm->lut);
  EXPECT_TRUE(has_none());
  EXPECT_EQ(loaded("is not used: it was taken with another look-up table"), 2U);
  ASSERT_TRUE(edit(forget_lut()));
  EXPECT_TRUE(has_both()) << "after a restart";
  EXPECT_EQ(loaded("is loaded"), 2U);
}

TEST_F(StoredItems, ACopyUnderAnotherNameIsNotUsed) {
  measure();
  fs::path reference;
  for (const auto& file : fs::directory_iterator(folder_)) {
    if (file.path().filename().string().starts_with("reference.")) reference = file.path();
  }
  fs::copy(reference, folder_ + "/reference.copy.json");
  start_with([](Config&) {});
  EXPECT_TRUE(has_both());
  EXPECT_EQ(loaded("its file name does not match its content"), 1U);
}

TEST_F(StoredItems, WhatCannotBeRemovedIsPutBack) {
  measure();
  ASSERT_TRUE(edit(use_lut(other_lut())));
  const fs::path lut = folder_ + "/lut.slm.json";
  fs::remove(lut);
  fs::create_directories(lut / "full");  // no unlink removes a folder
  const auto refused = edit(forget_lut());
  EXPECT_FALSE(refused);
  EXPECT_TRUE(keeper_->snapshot()->slm->lut);
  fs::remove_all(lut);
  EXPECT_TRUE(edit(forget_lut()));
  EXPECT_TRUE(has_both());
}

}  // namespace
}  // namespace ovws
