/// Spot assignment on synthetic lattices.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "core/tracking/spot_assignment.hpp"
#include "tests/support/alloc_guard.hpp"

namespace ovws {
namespace {

constexpr double kPitch = 60.0;

/// A hexagon of 3 + 4 + 5 + 4 + 3.
std::vector<Vec2> hexagon() {
  std::vector<Vec2> points;
  for (int row = -2; row <= 2; ++row) {
    const int count = 5 - std::abs(row);
    for (int k = 0; k < count; ++k) {
      points.push_back({256 + kPitch * (k - 0.5 * (count - 1)), 256 + 0.87 * kPitch * row});
    }
  }
  return points;
}

struct Shuffled {
  std::vector<Vec2> positions;
  std::vector<int> of_subaperture;  ///< index of its position; -1: missing
};

template <class Move>
Shuffled moved(const std::vector<Vec2>& lattice, const std::vector<int>& missing, Move move) {
  std::vector<int> order;
  for (int i = 0; i < int(lattice.size()); ++i) {
    if (std::find(missing.begin(), missing.end(), i) == missing.end()) order.push_back(i);
  }
  std::mt19937 random(5);
  std::shuffle(order.begin(), order.end(), random);
  Shuffled out{{}, std::vector<int>(lattice.size(), SpotAssignment::kNone)};
  for (const int i : order) {
    out.of_subaperture[i] = int(out.positions.size());
    out.positions.push_back(lattice[i] + move(lattice[i] - Vec2{256, 256}));
  }
  return out;
}

std::vector<int> match(SpotAssignment& assignment, const std::vector<Vec2>& found) {
  const auto span = assignment.match(found);
  return {span.begin(), span.end()};
}

TEST(SpotAssignment, FindsTheIndexOrderOfAnUnmovedLattice) {
  SpotAssignment assignment(hexagon(), 60);
  const Shuffled truth = moved(hexagon(), {}, [](Vec2) { return Vec2{}; });
  EXPECT_EQ(match(assignment, truth.positions), truth.of_subaperture);
}

TEST(SpotAssignment, FollowsAShiftOfMoreThanAPitch) {
  SpotAssignment assignment(hexagon(), 60);
  for (const Vec2 shift :
       {Vec2{60, 0}, Vec2{-60, 0}, Vec2{30, 52}, Vec2{-90, 100}, Vec2{31, -3}, Vec2{200, 130}}) {
    const Shuffled truth = moved(hexagon(), {}, [&](Vec2) { return shift; });
    EXPECT_EQ(match(assignment, truth.positions), truth.of_subaperture)
        << shift.x << "," << shift.y;
  }
}

TEST(SpotAssignment, FollowsTiltWithFocusAndAstigmatism) {
  SpotAssignment assignment(hexagon(), 60);
  for (const double s : {-0.5, -0.3, 0.3, 0.5}) {
    const auto focus = moved(hexagon(), {}, [&](Vec2 p) { return Vec2{25, -20} + s * p; });
    EXPECT_EQ(match(assignment, focus.positions), focus.of_subaperture);
    const auto zero = moved(hexagon(), {}, [&](Vec2 p) {
      return Vec2{-30, 10} + Vec2{s * p.x, -s * p.y};
    });
    EXPECT_EQ(match(assignment, zero.positions), zero.of_subaperture);
    const auto oblique = moved(hexagon(), {}, [&](Vec2 p) {
      return Vec2{40, 30} + Vec2{s * p.y, s * p.x};
    });
    EXPECT_EQ(match(assignment, oblique.positions), oblique.of_subaperture);
  }
}

TEST(SpotAssignment, AllowsMoreThanAnAffineMap) {
  SpotAssignment assignment(hexagon(), 60);
  const auto coma = moved(hexagon(), {}, [](Vec2 p) {
    const double x = p.x / 120, y = p.y / 120;
    return Vec2{5 * (3 * x * x + y * y - 0.7), 10 * x * y};
  });
  EXPECT_EQ(match(assignment, coma.positions), coma.of_subaperture);
}

TEST(SpotAssignment, LeavesMissingSpotsWithoutAPosition) {
  SpotAssignment assignment(hexagon(), 60);
  for (const auto& missing : {std::vector<int>{9}, {0}, {18, 17}, {0, 1, 2}, {3, 8, 12, 15}}) {
    const auto truth = moved(hexagon(), missing, [](Vec2 p) { return Vec2{20, 8} + 0.15 * p; });
    EXPECT_EQ(match(assignment, truth.positions), truth.of_subaperture);
  }
}

TEST(SpotAssignment, IsNotMisledByFalsePositions) {
  SpotAssignment assignment(hexagon(), 60);
  auto truth = moved(hexagon(), {4, 13}, [](Vec2 p) { return Vec2{-25, 12} - 0.1 * p; });
  std::mt19937 random(9);
  std::uniform_real_distribution<double> anywhere(40.0, 470.0);
  while (truth.positions.size() < 32) {
    const Vec2 p{anywhere(random), anywhere(random)};
    const auto near = [&](Vec2 q) { return norm(p - q) < 0.6 * kPitch; };
    if (std::none_of(truth.positions.begin(), truth.positions.end(), near) &&
        norm(p - (hexagon()[4] + Vec2{-25, 12})) > kPitch &&
        norm(p - (hexagon()[13] + Vec2{-25, 12})) > kPitch) {
      truth.positions.push_back(p);
    }
    if (random() == 0) break;
  }
  EXPECT_EQ(match(assignment, truth.positions), truth.of_subaperture);
}

/// A lattice without its right rim that has moved to the right by a pitch looks like one without
/// its left rim that has not moved. Only kinds of spots tell them apart.
TEST(SpotAssignment, KindsTellAShiftFromAMissingRim) {
  const std::vector<int> rim{2, 6, 11, 15, 18};
  const auto truth = moved(hexagon(), rim, [](Vec2) { return Vec2{kPitch, 0}; });
  std::vector<int> kinds(19);
  for (const int i : {3, 8, 10, 14}) kinds[i] = 1;
  std::vector<int> found_kinds(truth.positions.size());
  for (int i = 0; i < 19; ++i) {
    if (truth.of_subaperture[i] != SpotAssignment::kNone) {
      found_kinds[truth.of_subaperture[i]] = kinds[i];
    }
  }
  SpotAssignment alike(hexagon(), 60), of_kinds(hexagon(), 60, kinds);
  EXPECT_NE(match(alike, truth.positions), truth.of_subaperture);
  const auto matched = of_kinds.match(truth.positions, {}, found_kinds);
  EXPECT_EQ(std::vector<int>(matched.begin(), matched.end()), truth.of_subaperture);
}

/// Square lattice of the lenslets within `radius` pitches.
std::vector<Vec2> lenslets(double radius) {
  std::vector<Vec2> points;
  const int most = int(radius) + 1;
  for (int row = -most; row <= most; ++row) {
    for (int column = -most; column <= most; ++column) {
      const Vec2 p{kPitch * column, kPitch * row};
      if (norm(p) < radius * kPitch) points.push_back(Vec2{256, 256} + p);
    }
  }
  return points;
}

/// Light beyond the pupil fills every lenslet that a field shifted by a pitch needs, so that this
/// field explains one more if a lenslet at the rim is dark.
TEST(SpotAssignment, ADarkLensletDoesNotShiftTheLattice) {
  const auto pupil = lenslets(4.3), lit = lenslets(5.5);
  SpotAssignment assignment(pupil, 2 * int(pupil.size()) + 12);
  for (const Vec2 dark : pupil) {
    std::vector<Vec2> found;
    for (const Vec2 at : lit) {
      if (norm(at - dark) > 1.0) found.push_back(at + Vec2{3.0, -2.0});
    }
    const auto matched = match(assignment, found);
    for (std::size_t i = 0; i < pupil.size(); ++i) {
      if (matched[i] == SpotAssignment::kNone) continue;
      EXPECT_LT(norm(found[std::size_t(matched[i])] - pupil[i]), 5.0) << i;
    }
    EXPECT_EQ(std::ranges::count(matched, int(SpotAssignment::kNone)), 1);
  }
}

TEST(SpotAssignment, AFewDarkLensletsAtTheRimDoNotShiftTheLattice) {
  const auto pupil = lenslets(4.3), lit = lenslets(5.5);
  SpotAssignment assignment(pupil, 2 * int(pupil.size()) + 12);
  const std::vector<std::vector<Vec2>> cases{{{-4, 0}, {-4, -1}, {-4, 1}},  // pitches
                                             {{0, 0}, {-4, 0}, {-4, 1}},
                                             {{0, 0}, {-4, 0}, {-4, -1}, {-4, 1}},
                                             {{0, 4}, {1, 4}, {-1, 4}}};
  for (const auto& dark : cases) {
    std::vector<Vec2> found;
    for (const Vec2 at : lit) {
      const Vec2 from_middle = (1.0 / kPitch) * (at - Vec2{256, 256});
      const auto is_here = [&](Vec2 one) { return norm(one - from_middle) < 0.1; };
      if (std::ranges::none_of(dark, is_here)) found.push_back(at + Vec2{3.0, -2.0});
    }
    const auto matched = match(assignment, found);
    EXPECT_EQ(std::ranges::count(matched, int(SpotAssignment::kNone)), int(dark.size()));
    for (std::size_t i = 0; i < pupil.size(); ++i) {
      if (matched[i] == SpotAssignment::kNone) continue;
      EXPECT_LT(norm(found[std::size_t(matched[i])] - pupil[i]), 5.0) << i;
    }
  }
}

/// A growth over 1,200 lenslets takes 2 ms, and there are 640 of them.
TEST(SpotAssignment, FewLostAndFalseSpotsEndTheSearchAtOnce) {
  const auto pupil = lenslets(19.8);
  SpotAssignment assignment(pupil, 2 * int(pupil.size()) + 12);
  for (const double focus : {0.0, -0.02, 0.2}) {
    auto truth = moved(pupil, {5, 600, 1100}, [&](Vec2 p) { return Vec2{4, -2} + focus * p; });
    for (const double at : {100.0, 400.0, 830.0}) truth.positions.push_back({at, 321.0});
    EXPECT_EQ(match(assignment, truth.positions), truth.of_subaperture) << focus;
    EXPECT_LT(assignment.growths(), 8) << focus;
  }
}

/// Growths that repeat others, or explain too little, are abandoned.
TEST(SpotAssignment, FindsAShiftOfManyLensletsWithLostAndFalseSpots) {
  const auto pupil = lenslets(10.2);
  SpotAssignment assignment(pupil, 2 * int(pupil.size()) + 12);
  std::vector<int> lost;
  for (int i = 0; i < 320; i += 16) lost.push_back(i);
  auto truth = moved(pupil, lost, [](Vec2 p) { return Vec2{1.2 * kPitch, 0} + 0.1 * p; });
  for (int k = 0; k < 20; ++k) truth.positions.push_back({-300.0 + 57.0 * k, 13.0 * k});
  const auto matched = match(assignment, truth.positions);
  for (std::size_t i = 0; i < pupil.size(); ++i) {
    if (truth.of_subaperture[i] == SpotAssignment::kNone) continue;
    EXPECT_EQ(matched[i], truth.of_subaperture[i]);
  }
}

TEST(SpotAssignment, SaysNothingOfTooFewPositions) {
  SpotAssignment assignment(hexagon(), 60);
  const std::vector<int> none(19, SpotAssignment::kNone);
  EXPECT_EQ(match(assignment, {}), none);
  EXPECT_EQ(match(assignment, {{256, 256}}), none);
  const auto few =
      moved(hexagon(), {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13}, [](Vec2) { return Vec2{}; });
  EXPECT_EQ(match(assignment, few.positions), none);
}

TEST(SpotAssignment, ExpectsAMissingSpotWhereItsNeighboursSay) {
  SpotAssignment assignment(hexagon(), 60);
  const auto move = [](Vec2 p) { return Vec2{20, 8} + 0.15 * p; };
  const auto truth = moved(hexagon(), {7}, move);
  match(assignment, truth.positions);
  const Vec2 at = hexagon()[7] + move(hexagon()[7] - Vec2{256, 256});
  EXPECT_NEAR(assignment.expected(7).x, at.x, 0.5);
  EXPECT_NEAR(assignment.expected(7).y, at.y, 0.5);
}

TEST(SpotAssignment, DoesNotAllocate) {
  SpotAssignment assignment(hexagon(), 60);
  const auto truth = moved(hexagon(), {7}, [](Vec2 p) { return Vec2{20, 8} + 0.15 * p; });
  const test::AllocGuard guard;
  assignment.match(truth.positions);
  EXPECT_EQ(guard.allocations(), 0U);
}

}  // namespace
}  // namespace ovws
