/// Lost spots are expected where a smooth wavefront has put them.
#include "core/pipeline/neighbourhood.hpp"

#include <gtest/gtest.h>

#include "tests/unit/pipeline/spot_bench.hpp"

namespace ovws::test {
namespace {

std::vector<SpotFix> fixes_at(const std::vector<Vec2>& at_px, const std::vector<int>& lost) {
  std::vector<SpotFix> spots;
  for (const Vec2 at : at_px) spots.push_back({float(at.x), float(at.y), 200.0F, 1.0F, 200.0F});
  for (const int i : lost) spots[std::size_t(i)] = SpotFix{};
  return spots;
}

void expect_all_lost_found_within(const std::vector<Vec2>& truth, double bound_px) {
  const SpotBench bench;
  const Neighbourhood neighbourhood(bench.model_px);
  for (int lost = 0; lost < bench.spots(); ++lost) {
    const std::vector<SpotFix> spots = fixes_at(truth, {lost});
    const Vec2 expected = neighbourhood.expect(lost, neighbourhood.fit(spots), spots);
    EXPECT_LT(norm(expected - truth[std::size_t(lost)]), bound_px) << "spot " << lost;
  }
}

TEST(Neighbourhood, TiltFocusAndAstigmatismPutAnyLostSpotWithinATenthOfAPixel) {
  const SpotBench bench;
  expect_all_lost_found_within(bench.moved({{3, 0.5}, {4, -0.8}, {5, 0.3}}, {40.0, -25.0}), 0.1);
}

TEST(Neighbourhood, AThirdOrderAberrationPutsAnyLostSpotWithinHalfOfLambdaOverD) {
  const SpotBench bench;
  expect_all_lost_found_within(bench.moved({{7, 0.1}, {8, -0.05}}), 6.0);
}

TEST(Neighbourhood, OneFoundSpotGivesItsDisplacementToAll) {
  const SpotBench bench;
  const Neighbourhood neighbourhood(bench.model_px);
  std::vector<SpotFix> spots(std::size_t(bench.spots()));
  const Vec2 at = bench.model_px[9] + Vec2{7.0, -3.0};
  spots[9] = {float(at.x), float(at.y), 200.0F, 1.0F, 200.0F};
  const DisplacementField field = neighbourhood.fit(spots);
  for (int i = 0; i < bench.spots(); ++i) {
    const Vec2 moved = neighbourhood.expect(i, field, spots) - bench.model_px[std::size_t(i)];
    EXPECT_NEAR(moved.x, 7.0, 0.1);
    EXPECT_NEAR(moved.y, -3.0, 0.1);
  }
}

TEST(Neighbourhood, WithNothingFoundSpotsAreExpectedWherePredicted) {
  const SpotBench bench;
  const Neighbourhood neighbourhood(bench.model_px);
  const std::vector<SpotFix> spots(std::size_t(bench.spots()));
  const DisplacementField field = neighbourhood.fit(spots);
  EXPECT_EQ(neighbourhood.expect(3, field, spots), bench.model_px[3]);
}

TEST(Neighbourhood, TwoNeighboursOnOneSpotAreDoubledAndNobodyElseIs) {
  const SpotBench bench;
  const Neighbourhood neighbourhood(bench.model_px);
  std::vector<Vec2> at = bench.model_px;
  at[10] = at[9] + Vec2{2.0, 1.0};
  const std::vector<SpotFix> spots = fixes_at(at, {});
  for (int i = 0; i < bench.spots(); ++i) {
    EXPECT_EQ(neighbourhood.is_duplicate(i, spots), i == 9 || i == 10) << "spot " << i;
  }
}

TEST(Neighbourhood, ALostSpotIsNeverDoubled) {
  const SpotBench bench;
  const Neighbourhood neighbourhood(bench.model_px);
  const std::vector<SpotFix> spots = fixes_at(bench.model_px, {4});
  EXPECT_FALSE(neighbourhood.is_duplicate(4, spots));
}

}  // namespace
}  // namespace ovws::test
