/// The external corrector: what it multiplies, what it refuses, and what it reports.
#include "daemon/ovwsd/streams/corrector.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "daemon/ovwsd/actor/stream_queue.hpp"

namespace ovws {
namespace {

const std::vector<int> kModes{1, 2, 3};

std::string float_bytes(const std::vector<float>& values) {
  std::string bytes(sizeof(float) * values.size(), '\0');
  std::memcpy(bytes.data(), values.data(), bytes.size());
  return bytes;
}

class CorrectorTest : public testing::Test {
 protected:
  CorrectorTest() {
    plan_.modes_j = kModes;
    record_.plan = &plan_;
    record_.coefficients = {0.5F, -1.0F, 2.0F, 99.0F};  // records have room for more modes
    record_.mode_count = 3;
    record_.valid = true;
  }

  std::vector<float> commands() {
    const CorrectorMatrix* const matrix = corrector_.matrix();
    if (matrix == nullptr) return {};
    const auto values = corrector_.commands(*matrix, record_);
    return {values.begin(), values.end()};
  }
  std::string refused_field(std::vector<int> shape, const std::string& bytes) {
    const auto set = corrector_.set({std::move(shape)}, bytes, kModes);
    return set ? "accepted" : set.error().field;
  }
  /// The text of the next event; empty: none.
  std::string event() {
    const auto message = queue_.take();
    return message ? std::get<EventMessage>(*message).text : "";
  }

  StreamQueue queue_;
  Events events_{queue_};
  Corrector corrector_{events_};
  MeasurementPlan plan_;
  FrameRecord record_;
};

const std::vector<float> kMatrix{1, 2, 3, 0, 0, -0.5F};

TEST_F(CorrectorTest, GivesTheMatrixTimesTheModesOfTheFrame) {
  EXPECT_TRUE(commands().empty()) << "no matrix";
  ASSERT_TRUE(corrector_.set({{2, 3}}, float_bytes(kMatrix), kModes));
  EXPECT_EQ(commands(), (std::vector<float>{4.5F, -1.0F}));
  EXPECT_EQ(commands(), (std::vector<float>{4.5F, -1.0F})) << "nothing is integrated";
  ASSERT_TRUE(corrector_.set({{1, 3}}, float_bytes({0, 1, 0}), kModes));
  EXPECT_EQ(commands(), (std::vector<float>{-1.0F})) << "the last matrix counts";
  corrector_.clear();
  EXPECT_TRUE(commands().empty());
}

TEST_F(CorrectorTest, GivesNothingForFramesThatAreNotValidOrHaveOtherModes) {
  ASSERT_TRUE(corrector_.set({{2, 3}}, float_bytes(kMatrix), kModes));
  record_.valid = false;
  EXPECT_TRUE(commands().empty());
  record_.valid = true;
  plan_.modes_j = {1, 2, 4};
  EXPECT_TRUE(commands().empty());
  plan_.modes_j = {1, 2};
  EXPECT_TRUE(commands().empty());
}

TEST_F(CorrectorTest, RefusesWhatDoesNotFitAndKeepsTheMatrixOfBefore) {
  ASSERT_TRUE(corrector_.set({{2, 3}}, float_bytes(kMatrix), kModes));
  EXPECT_EQ(refused_field({2, 4}, float_bytes(std::vector<float>(8))), "shape");
  EXPECT_EQ(refused_field({2, 3}, float_bytes(kMatrix) + "x"), "matrix");
  EXPECT_EQ(refused_field({2, 3}, ""), "matrix");
  EXPECT_EQ(refused_field({2, 3}, float_bytes({1, 2, 3, 4, NAN, 6})), "matrix");
  EXPECT_EQ(refused_field({2, 3}, float_bytes({1, 2, INFINITY, 4, 5, 6})), "matrix");
  EXPECT_EQ(corrector_.report(kModes).matrix, 1);
  EXPECT_EQ(commands(), (std::vector<float>{4.5F, -1.0F}));
}

TEST_F(CorrectorTest, TakesTheLargestMatrix) {
  const int actuators = limits::kActuators.max;
  std::vector<int> modes_j(kMaxZernikeIndex);
  for (int j = 1; j <= kMaxZernikeIndex; ++j) modes_j[std::size_t(j - 1)] = j;
  const std::size_t bytes = sizeof(float) * std::size_t(actuators) * kMaxZernikeIndex;
  ASSERT_LE(bytes, kMaxMatrixBytes);
  ASSERT_TRUE(corrector_.set({{actuators, kMaxZernikeIndex}}, std::string(bytes, '\0'), modes_j));
  plan_.modes_j = modes_j;
  record_.coefficients.assign(std::size_t(kMaxModes), 1.0F);
  EXPECT_EQ(commands(), std::vector<float>(std::size_t(actuators)));
}

TEST_F(CorrectorTest, ReportsWhyThereAreNoCommands) {
  EXPECT_NE(corrector_.report(kModes).reason.find("corrector.set"), std::string::npos);
  EXPECT_FALSE(corrector_.report(kModes).matrix);
  ASSERT_TRUE(corrector_.set({{2, 3}}, float_bytes(kMatrix), kModes));
  const KnownCorrector known = corrector_.report(kModes);
  EXPECT_EQ(known.reason, "");
  EXPECT_EQ(known.actuators, 2);
  EXPECT_EQ(known.modes_j, kModes);
  const auto why = [this](const std::vector<int>& modes_j) {
    return corrector_.report(modes_j).reason;
  };
  EXPECT_NE(why({4, 5, 6, 9}).find("modes j = 1 to 3, but the sensor now measures j = 4 to 6, 9:"),
            std::string::npos)
      << why({4, 5, 6, 9});
}

TEST_F(CorrectorTest, AnEventTellsWhenTheModesChangeAndWhenTheyAreAsBefore) {
  corrector_.sensor_changed(kModes);
  corrector_.sensor_changed({1, 2});
  EXPECT_EQ(event(), "") << "without a matrix";
  corrector_.sensor_changed(kModes);
  ASSERT_TRUE(corrector_.set({{2, 3}}, float_bytes(kMatrix), kModes));
  EXPECT_NE(event().find("2 actuators"), std::string::npos);
  corrector_.sensor_changed(kModes);
  EXPECT_EQ(event(), "");
  corrector_.sensor_changed({1, 2});
  EXPECT_NE(event().find("set another one"), std::string::npos);
  corrector_.sensor_changed({1, 2, 3, 4});
  EXPECT_EQ(event(), "") << "once";
  corrector_.sensor_changed(kModes);
  EXPECT_NE(event().find("again"), std::string::npos);
  corrector_.clear();
  EXPECT_NE(event().find("corrector.clear"), std::string::npos);
  corrector_.clear();
  EXPECT_EQ(event(), "");
}

}  // namespace
}  // namespace ovws
