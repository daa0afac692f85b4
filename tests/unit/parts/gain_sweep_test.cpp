/// The gain sweep of `ovws study experiment`: its params, and the evaluation of its frames.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>

#include "core/optics/lattice.hpp"
#include "core/wavefront/residual_variance.hpp"
#include "daemon/ovws/study/sweep_sensor.hpp"
#include "daemon/ovwsd/layout/mode_operators.hpp"

namespace ovws {
namespace {

using nlohmann::json;
using study::judge_frames, study::levels_of, study::mean_positions, study::SweepFrame;

/// A frame whose spots were all found, at these places.
SweepFrame frame_at(const std::vector<Vec2>& places) {
  SweepFrame frame;
  for (const Vec2 p : places) {
    SpotFix spot;
    spot.x = float(p.x);
    spot.y = float(p.y);
    spot.level = 10.0F;
    spot.noise = 2.0F;
    spot.peak = 20.0F;
    frame.spots.push_back(spot);
  }
  return frame;
}

TEST(GainSweep, IsThePapersUnlessSetOtherwise) {
  const auto sweep = decode<GainSweep>(json::object());
  ASSERT_TRUE(sweep);
  EXPECT_EQ(sweep->gains_db.size(), 16U);
  EXPECT_EQ(sweep->frames, 100);
  ASSERT_EQ(sweep->aberrations.size(), 3U);
  EXPECT_NEAR(sweep->aberrations[2].modes[0].waves, 2.0 / std::sqrt(6.0), 1e-12);
  EXPECT_EQ(sweep->arms[2], (SweepArm{0, {TrackerKind::centroid, true}}));
  EXPECT_EQ(sweep->cells(), 192U);
  const GainSweep::Cell at = sweep->cell(64 + 4 + 3);
  EXPECT_EQ(at.aberration, 1U);
  EXPECT_EQ(at.gain, 1U);
  EXPECT_EQ(at.arm, 3U);
}

TEST(GainSweep, ComesBackFromItsJson) {
  const auto sweep = decode<GainSweep>(
      {{"gains_db", {3, 1.5}},
       {"aberrations", {{{"modes", {{{"n", 2}, {"m", 0}, {"waves", 1}}}}, {"norm", "unit"}}}},
       {"arms", {{{"charge", 0}, {"tracker", "cell_centroid"}}}},
       {"clamp", true}});
  ASSERT_TRUE(sweep);
  EXPECT_TRUE(sweep->clamp);
  const auto again = decode<GainSweep>(to_json(*sweep));
  ASSERT_TRUE(again);
  EXPECT_EQ(to_json(*again), to_json(*sweep));
  EXPECT_EQ(again->arms, sweep->arms);
  EXPECT_EQ(again->gains_db, (std::vector<double>{3, 1.5}));
  EXPECT_NEAR(again->aberrations[0].modes[0].waves, 1.0 / std::sqrt(3.0), 1e-12);
}

TEST(GainSweep, NamesWhatIsWrong) {
  const auto field = [](const json& params) { return decode<GainSweep>(params).error().field; };
  EXPECT_EQ(field({{"gains_db", {1, 2, 1}}}), "gains_db");
  EXPECT_EQ(field({{"gains_db", json::array()}}), "gains_db");
  EXPECT_EQ(field({{"frames", 1}}), "frames");
  EXPECT_EQ(field({{"arms", json::array()}}), "arms");
  EXPECT_EQ(field({{"arms", {{{"charge", 1}, {"tracker", "lgg"}}}}}), "arms[0].tracker");
  EXPECT_EQ(field({{"aberrations", {{{"modes", {{{"j", 3}}}}}}}}), "aberrations[0].modes[0].waves");
}

json numbers_to(std::size_t count) {
  json numbers = json::array();
  for (std::size_t k = 0; k < count; ++k) numbers.push_back(k);
  return numbers;
}

/// Sweep arms that all differ in charge or tracker.
json arms_of(std::size_t count) {
  json arms = json::array();
  for (std::size_t k = 0; k < count; ++k) {
    arms.push_back({{"charge", int(k % 9)}, {"tracker", k < 9 ? "lg" : "fit"}});
  }
  return arms;
}

json aberrations_of(std::size_t count) {
  return json(count, {{"modes", {{{"j", 3}, {"waves", 0.1}}}}});
}

TEST(GainSweep, HasSixteenThousandCellsAtMost) {
  const json largest{
      {"gains_db", numbers_to(64)}, {"arms", arms_of(16)}, {"aberrations", aberrations_of(16)}};
  const auto sweep = decode<GainSweep>(largest);
  ASSERT_TRUE(sweep) << sweep.error().reason;
  EXPECT_EQ(sweep->cells(), 16384U);
  const GainSweep::Cell last = sweep->cell(16383);
  EXPECT_EQ((std::array{last.arm, last.aberration, last.gain}),
            (std::array<std::size_t, 3>{15, 15, 63}));
  const auto refusal = [&largest](const char* key, const json& more) {
    json params = largest;
    params[key] = more;
    const Error error = decode<GainSweep>(params).error();
    EXPECT_EQ(error.field, key);
    return error.reason;
  };
  EXPECT_EQ(refusal("gains_db", numbers_to(65)), "must be an array of 1 to 64 numbers");
  EXPECT_EQ(refusal("arms", arms_of(17)), "must be an array of at most 16 objects");
  EXPECT_EQ(refusal("aberrations", aberrations_of(17)), "must be an array of 1 to 16 objects");
}

TEST(GainSweep, ReportsSaturatedAndUndeterminedFramesSeparately) {
  CellMeasured cell;
  cell.subapertures = 19;
  cell.modes_j = {1};
  cell.frames = {{{0.1}, 1.0, 0.0, 19}, {{0.2}, 3.0, 0.1, 19}, {{}, NAN, 0.0, 4}};
  const json encoded = report_of(cell);
  EXPECT_EQ(encoded["variance_rad2"], 2.0);
  EXPECT_NEAR(encoded["standard_deviation_rad2"].get<double>(), std::sqrt(2.0), 1e-12);
  EXPECT_NEAR(encoded["standard_error_rad2"].get<double>(), 1.0, 1e-12);
  EXPECT_EQ(encoded["unsaturated_variance_rad2"], 1.0);
  EXPECT_EQ(encoded["saturated_frames"], 1);
  EXPECT_EQ(encoded["undetermined_frames"], 1);
  EXPECT_EQ(encoded["lost_spots"], 15);
  EXPECT_TRUE(encoded["variances_rad2"][2].is_null());
}

TEST(MeanPositions, LeaveOutWhatIsRarelyFound) {
  std::vector<SweepFrame> frames(3, frame_at({{1, 2}, {5, 5}}));
  frames[1].spots[0].x = 4.0F;
  frames[0].spots[1] = frames[1].spots[1] = SpotFix{};
  const auto mean = mean_positions(frames);
  ASSERT_EQ(mean.size(), 2U);
  EXPECT_DOUBLE_EQ(mean[0].x, 2.0);
  EXPECT_DOUBLE_EQ(mean[0].y, 2.0);
  EXPECT_TRUE(std::isnan(mean[1].x));
  EXPECT_TRUE(mean_positions({}).empty());
}

TEST(Levels, AreMediansOfFoundSpots) {
  std::vector<SweepFrame> frames(1, frame_at({{1, 1}, {2, 2}, {3, 3}}));
  frames[0].spots[0].level = 1000.0F;
  frames[0].spots[1] = SpotFix{};
  frames[0].spots[1].peak = 255.0F;  // lost, and saturated
  const SpotLevels levels = levels_of(frames);
  EXPECT_EQ(levels.noise_dn, 2.0);
  EXPECT_EQ(levels.peak_dn, 255.0);
  EXPECT_TRUE(std::isnan(levels_of({}).level_dn));
}

/// Spots that moved exactly as the model predicts leave only the error that was not introduced.
TEST(JudgeFrames, ReportsTheResidual) {
  const SlmGeometry slm;
  const SensorConfig sensor;
  const auto lattice = make_lattice(sensor, slm);
  ASSERT_TRUE(lattice);
  const ModeOperator model =
      slope_operator(*lattice, sensor, TrackingSettings{}, px_per_cycle(OpticsConfig{}, slm));
  const std::size_t spots = lattice->subapertures.size();
  const std::vector<Vec2> reference(spots, Vec2{100.0, 100.0});
  const Reconstructor reconstructor(model.slopes, model.modes_j, reference);
  Eigen::VectorXd waves = Eigen::VectorXd::Zero(model.slopes.cols());
  waves[2] = 0.5;   // j = 3, introduced
  waves[3] = 0.01;  // j = 4, an error
  const Eigen::VectorXd moved = model.slopes * waves;
  std::vector<Vec2> places = reference;
  for (std::size_t i = 0; i < spots; ++i) {
    places[i] = places[i] + Vec2{moved[Eigen::Index(2 * i)], moved[Eigen::Index(2 * i + 1)]};
  }
  std::vector<SweepFrame> frames(2, frame_at(places));
  frames[0].saturated_fraction = 0.5;
  for (SpotFix& spot : frames[1].spots) spot = SpotFix{};
  const auto judged = judge_frames(frames, reconstructor, {{3, 0.5}});
  ASSERT_EQ(judged.size(), 2U);
  const double expected = 4.0 * std::numbers::pi * std::numbers::pi * 0.01 * 0.01;
  EXPECT_NEAR(judged[0].variance_rad2, expected, 0.01 * expected);
  EXPECT_NEAR(judged[0].coefficients[2], 0.5, 1e-4);
  EXPECT_EQ(judged[0].saturated_fraction, 0.5);
  EXPECT_EQ(judged[0].tracked, int(spots));
  EXPECT_TRUE(std::isnan(judged[1].variance_rad2));
  EXPECT_TRUE(judged[1].coefficients.empty());
  EXPECT_EQ(judged[1].tracked, 0);
}

TEST(ResidualVariance, IsOfModesThatAreNotMeasuredTooIfTheyAreFound) {
  const std::vector<int> modes_j{1, 3};
  const std::vector<double> found{0.1, 0.3};
  const std::vector<Mode> introduced{{3, 0.3}, {9, 1.0}};
  const double by = 4.0 * std::numbers::pi * std::numbers::pi;
  EXPECT_NEAR(residual_variance_rad2<double>(modes_j, found, introduced), by * 0.01, 1e-12);
}

}  // namespace
}  // namespace ovws
