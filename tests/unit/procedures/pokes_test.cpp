/// A calibration on a bench that moves, or whose SLM is late.
#include <gtest/gtest.h>

#include <functional>
#include <vector>

#include "tests/unit/procedures/on_bench.hpp"

namespace ovws {
namespace {

using test::calibrate_on;
using test::SimulatedBench;
using test::take_reference_on;

/// Changes the bench by `change` before picture `begin` is shown, and back before picture `end`;
/// the first is 1.
class Bump {
 public:
  Bump(SimulatedBench& bench, int begin, int end, const std::function<void(twin::Truth&)>& change)
      : optics_(bench.optics()), resting_(optics_.truth()), begin_(begin), end_(end) {
    twin::Truth changed = resting_;
    change(changed);
    optics_.before_show([this, changed] {
      ++picture_;
      if (picture_ == begin_) optics_.set_truth(changed);
      if (picture_ == end_) optics_.set_truth(resting_);
    });
  }
  ~Bump() {
    optics_.before_show({});
    EXPECT_GE(picture_, end_);
  }

 private:
  test::SimulatedOptics& optics_;
  const twin::Truth resting_;
  const int begin_, end_;
  int picture_ = 0;
};

/// A bump begins between the two images of one mode and ends between those of another.
TEST(Pokes, ABumpOfTheBenchIsNotTakenForAModesResponse) {
  SimulatedBench bench;
  ASSERT_TRUE(take_reference_on(bench, 10));
  const auto still = calibrate_on(bench, 0.1, {1, 2, 3, 4, 5});
  ASSERT_TRUE(still) << still.error().reason;
  for (const int begin : {1, 2, 3, 4}) {
    const Bump bump(bench, begin, begin + 6,
                    [](twin::Truth& moved) { moved.geometry.centre_px.x += 3.0; });
    const auto found = calibrate_on(bench, 0.1, {1, 2, 3, 4, 5});
    ASSERT_TRUE(found) << found.error().reason;
    ASSERT_EQ(found->matrix.modes_j, still->matrix.modes_j);
    const double error = (found->matrix.slopes - still->matrix.slopes).norm();
    EXPECT_LT(error, 0.02 * still->matrix.slopes.norm()) << "from picture " << begin;
  }
}

/// As if a tenth of the frames of one picture still had the picture before it: 5 % of the response.
/// Two calibrations differ by 1 % of noise, on a busy machine by up to 1.7 %.
TEST(Pokes, ALatePictureIsNotTakenForAModesResponse) {
  constexpr double kPoke = 0.05;
  SimulatedBench bench;
  ASSERT_TRUE(take_reference_on(bench, 10));
  const auto prompt = calibrate_on(bench, kPoke, {5}, 20);
  ASSERT_TRUE(prompt) << prompt.error().reason;
  for (const int picture : {1, 2, 3, 4}) {
    const double part = picture % 2 == 0 ? 0.1 : -0.1;  // weakens the poke of this picture
    const Bump bump(bench, picture, picture + 1, [=](twin::Truth& late) {
      late.aberration.push_back({5, 2 * part * kPoke});
    });
    const auto found = calibrate_on(bench, kPoke, {5}, 20);
    ASSERT_TRUE(found) << found.error().reason;
    const double error = (found->matrix.slopes - prompt->matrix.slopes).norm();
    EXPECT_LT(error, 0.02 * prompt->matrix.slopes.norm()) << "picture " << picture;
  }
}

/// Responses that differ by 10 % each time: those used are named.
TEST(Pokes, AnUnsteadyResponseIsReported) {
  constexpr double kPoke = 0.05;
  SimulatedBench bench;
  ASSERT_TRUE(take_reference_on(bench, 10));
  const auto steady = calibrate_on(bench, kPoke, {5}, 20);
  ASSERT_TRUE(steady) << steady.error().reason;
  EXPECT_TRUE(steady->unsteady_j.empty());
  const twin::Truth resting = bench.optics().truth();
  bench.optics().before_show([&bench, resting, picture = 0]() mutable {
    const bool is_plus = picture % 2 == 0, is_strong = picture / 2 % 2 == 0;
    twin::Truth truth = resting;
    truth.aberration.push_back({5, is_plus == is_strong ? 0.05 * kPoke : -0.05 * kPoke});
    bench.optics().set_truth(truth);
    ++picture;
  });
  const auto found = calibrate_on(bench, kPoke, {5}, 20);
  bench.optics().before_show({});
  ASSERT_TRUE(found) << found.error().reason;
  EXPECT_EQ(found->unsteady_j, (std::vector<int>{5}));
  const double error = (found->matrix.slopes - steady->matrix.slopes).norm();
  EXPECT_LT(error, 0.02 * steady->matrix.slopes.norm()) << "the mean of two";
}

}  // namespace
}  // namespace ovws
