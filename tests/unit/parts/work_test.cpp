#include "daemon/ovws/study/work.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numeric>

#include "daemon/ovws/study/statistics.hpp"
#include "daemon/ovws/study/studies.hpp"

namespace ovws::study {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

TEST(Work, a_result_reads_back_the_same) {
  for (const double value : {0.1, 1.0 / 3.0, -0.0, 5e-324, 1.7976931348623157e308, double(0.1F),
                             kInfinity, -kInfinity}) {
    const Mean mean{value, 2.0 * value, 17};
    const auto read = result_of(result_text(mean)).get<Mean>();
    EXPECT_EQ(read.value, mean.value);
    EXPECT_EQ(std::signbit(read.value), std::signbit(mean.value));
    EXPECT_EQ(read.standard_error, mean.standard_error);
    EXPECT_EQ(read.count, mean.count);
  }
  const std::vector<double> unknown{kUnknown, -kUnknown, 1.0};
  const auto read = result_of(result_text(unknown)).get<std::vector<double>>();
  EXPECT_TRUE(std::isnan(read[0]) && std::isnan(read[1]));
  EXPECT_EQ(std::signbit(read[0]), std::signbit(read[1])) << "a NaN has no sign in a part";
  EXPECT_EQ(read[2], 1.0);
}

TEST(Work, an_item_has_the_same_result_whoever_measures_it) {
  for (const char* name : {"localisation", "acquisition"}) {
    const Work work = study_named(name)->prepare({true, 3});
    std::vector<std::size_t> all(work.items);
    std::iota(all.begin(), all.end(), std::size_t{0});
    const auto together = measure_items(work, name, all, 2);
    const std::vector<std::size_t> some{work.items - 1, 0, work.items / 2};
    const auto apart = measure_items(study_named(name)->prepare({true, 3}), name, some, 1);
    for (std::size_t k = 0; k < some.size(); ++k) EXPECT_EQ(apart[k], together[some[k]]) << name;
    EXPECT_NE(measure_items(study_named(name)->prepare({true, 4}), name, {0}, 1)[0], together[0]);
  }
}

TEST(Work, a_study_is_found_by_its_name) {
  for (const Study& study : kStudies) {
    ASSERT_NE(study_named(study.name), nullptr);
    EXPECT_EQ(study_named(study.name)->prepare, study.prepare);
  }
  EXPECT_EQ(study_named("experiment"), nullptr);
}

}  // namespace
}  // namespace ovws::study
