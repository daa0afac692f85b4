/// Frames of a DMD's sequence: each is measured with the plan of its pattern, or not at all.
#include <gtest/gtest.h>

#include "tests/support/alloc_guard.hpp"
#include "tests/unit/pipeline/pipeline_rig.hpp"

namespace ovws::test {
namespace {

constexpr int kSlots = 4;
constexpr std::uint64_t kSequence = 2;  // hologram

/// Three patterns, one of them with strong tilt; the rig's frames are 10 ms apart.
class Patterns : public ::testing::TestWithParam<int> {
 protected:
  Patterns() : rig_(GetParam(), 64, 8, 0, 3) {
    auto plan = rig_.bench.plan(1);
    plan->hologram_id = kSequence;
    plan->cycle = {kSlots, 10 * kMs};
    for (const auto& modes : modes_) {
      auto pattern = rig_.bench.plan(1);
      pattern->hologram_id = kSequence;
      pattern->predicted_px = rig_.bench.moved(modes);
      plan->patterns.push_back(std::move(pattern));
    }
    rig_.use(std::move(plan));
    show(kSequence, true);
    rig_.stamped = true;
    if (const auto attached = rig_.attach(); !attached) ADD_FAILURE();
  }

  void show(std::uint64_t hologram_id, bool sequence) {
    rig_.show({hologram_id, 1, 0, kMs, sequence}, {});
  }

  std::shared_ptr<const Image<std::uint8_t>> picture(std::uint64_t frame_id) const {
    const std::size_t slot = frame_id % kSlots;
    return slot == 0 ? SpotBench::black() : SpotBench::draw(rig_.bench.moved(modes_[slot - 1]));
  }

  const std::vector<std::vector<Mode>> modes_{{}, {{1, 0.6}, {4, 0.3}}, {{5, -0.3}}};
  PipelineRig rig_;
};

TEST_P(Patterns, EachFrameIsMeasuredWithItsPatternsPlan) {
  int valid = 0;
  for (std::uint64_t id = 1; id <= 60; ++id) {
    const bool lost = id == 20 || id == 28 || id == 37;  // marks, and a pattern
    if (lost) continue;
    const auto image = picture(id);
    const Taken record(rig_, rig_.measure(id, image));
    ASSERT_TRUE(bool(record));
    if (record->valid) {
      ++valid;
      ASSERT_EQ(record->pattern, int(id % kSlots) - 1) << "frame " << id;
      const std::vector<Mode>& modes = modes_[std::size_t(record->pattern)];
      for (int k = 0; k < record->mode_count; ++k) {
        const int j = record->plan->modes_j[std::size_t(k)];
        double waves = 0.0;
        for (const Mode& mode : modes) waves += mode.j == j ? mode.waves : 0.0;
        EXPECT_NEAR(double(record->coefficients[std::size_t(k)]), waves, 0.02) << id << ' ' << j;
      }
    } else {
      EXPECT_FALSE(record->settled);
      EXPECT_EQ(record->pattern, -1) << "frame " << id;
      EXPECT_EQ(record->tracked, 0);
    }
  }
  // From the second mark (8) on, all but the marks, and the cycles after the two lost marks.
  EXPECT_EQ(valid, 39 - 2 * 3 - 1);
}

TEST_P(Patterns, FramesOfAnotherHologramAreNotMeasuredByTheSequencesPlan) {
  show(1, false);
  for (std::uint64_t id = 1; id <= 20; ++id) {
    const Taken record(rig_, rig_.measure(id, picture(id)));
    ASSERT_TRUE(bool(record));
    EXPECT_FALSE(record->settled);
    EXPECT_FALSE(record->valid);
  }
}

TEST_P(Patterns, FramesOfASequenceAreNotMeasuredByAnotherPlan) {
  rig_.use(rig_.bench.plan(2));
  for (std::uint64_t id = 1; id <= 20; ++id) {
    const Taken record(rig_, rig_.measure(id, picture(id)));
    ASSERT_TRUE(bool(record));
    EXPECT_FALSE(record->valid);
    EXPECT_EQ(record->pattern, -1);
  }
}

TEST_P(Patterns, FramesOfASequenceAreNotMeasuredByAPlanOfItsHologramWithoutPatterns) {
  auto plan = rig_.bench.plan(2);
  plan->hologram_id = kSequence;
  rig_.use(std::move(plan));
  for (std::uint64_t id = 1; id <= 20; ++id) {
    const Taken record(rig_, rig_.measure(id, picture(id)));
    ASSERT_TRUE(bool(record));
    EXPECT_FALSE(record->settled);
  }
}

TEST_P(Patterns, ExposuresLongerThanASlotAndFramesWithoutATimestampAreUncertain) {
  for (const bool stamped : {false, true}) {
    rig_.stamped = stamped;
    rig_.applied.exposure_us = stamped ? 11e3 : 1e3;
    rig_.settings.write(rig_.applied);
    for (std::uint64_t id = 1; id <= 30; ++id) {
      const std::uint64_t frame_id = id + (stamped ? 100 : 0);
      const Taken record(rig_, rig_.measure(frame_id, picture(frame_id)));
      ASSERT_TRUE(bool(record));
      EXPECT_EQ(record->pattern, -1) << frame_id;
      EXPECT_FALSE(record->valid);
    }
  }
}

TEST_P(Patterns, NothingIsAllocatedOnTheFramePath) {
  for (std::uint64_t id = 1; id <= 12; ++id) Taken(rig_, rig_.measure(id, picture(id)));
  std::vector<std::shared_ptr<const Image<std::uint8_t>>> pictures;
  for (std::uint64_t id = 0; id < 4; ++id) pictures.push_back(picture(id));
  int valid = 0;
  for (std::uint64_t id = 13; id <= 40; ++id) {
    rig_.send(id, pictures[id % 4]);
    const AllocGuard guard;
    rig_.turn();
    EXPECT_EQ(guard.allocations(), 0U) << "frame " << id;
    const Taken record(rig_, rig_.pipeline.next(0));
    valid += bool(record) && record->valid ? 1 : 0;
  }
  EXPECT_EQ(valid, 21);
}

INSTANTIATE_TEST_SUITE_P(Workers, Patterns, ::testing::Values(0, 2));

}  // namespace
}  // namespace ovws::test
