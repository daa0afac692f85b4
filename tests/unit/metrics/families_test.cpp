/// Metric families made from status and wavefront messages: complete ones, and malformed ones.
#include "daemon/ovws/metrics/families.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "core/rt/counters.hpp"
#include "daemon/ovws/metrics/exporter.hpp"
#include "daemon/shared/schemas/schemas.hpp"

namespace ovws::metrics {
namespace {

using nlohmann::json;
using prometheus::MetricFamily;

/// The example in a stream's JSON Schema.
json example(const char* name) {
  return schema(name).at("examples").at(0);
}

const MetricFamily* find(const std::vector<MetricFamily>& all, const std::string& name) {
  const auto at =
      std::find_if(all.begin(), all.end(), [&](const auto& one) { return one.name == name; });
  return at == all.end() ? nullptr : &*at;
}

TEST(Families, WithoutADaemonSayOnlyThat) {
  const auto all = families(std::nullopt, example("stream.wavefront"));
  ASSERT_EQ(all.size(), 1U);
  EXPECT_EQ(all[0].name, "ovws_up");
  EXPECT_EQ(all[0].metric[0].gauge.value, 0.0);
}

TEST(Families, EveryCounterHasItsWords) {
  json status = example("stream.status");
  for (std::size_t i = 0; i < std::size_t(Counter::count_); ++i) {
    const std::string name(counter_name(Counter(i)));
    EXPECT_FALSE(all_counters()[i].help.empty()) << name;
    status["counters"][name] = i;
  }
  const auto all = families(status, std::nullopt);
  const auto* published = find(all, "ovws_frames_published_total");
  ASSERT_NE(published, nullptr);
  EXPECT_EQ(published->type, prometheus::MetricType::Counter);
  EXPECT_EQ(published->metric[0].counter.value, double(Counter::frames_published));
}

TEST(Families, AreInBaseUnits) {
  const auto all = families(example("stream.status"), example("stream.wavefront"));
  EXPECT_NEAR(find(all, "ovws_camera_exposure_seconds")->metric[0].gauge.value, 0.002, 1e-12);
  EXPECT_NEAR(find(all, "ovws_wavefront_wavelength_meters")->metric[0].gauge.value, 632e-9, 1e-15);
  const auto& latency = find(all, "ovws_frame_latency_seconds")->metric.at(0);
  EXPECT_EQ(latency.histogram.sample_count, 1250U);
  EXPECT_NEAR(latency.histogram.sample_sum, 0.1125, 1e-12);
  EXPECT_EQ(latency.histogram.bucket.at(7).upper_bound, 98.304e-6);
  EXPECT_EQ(latency.histogram.bucket.at(7).cumulative_count, 1000U);
}

TEST(Families, LeaveOutWhatIsNotKnown) {
  json wavefront = example("stream.wavefront");
  wavefront["valid"] = false;
  wavefront["rms_waves"] = nullptr;
  for (json& value : wavefront["coefficients"]) value = nullptr;
  const auto all = families(example("stream.status"), wavefront);
  EXPECT_EQ(find(all, "ovws_wavefront_valid")->metric[0].gauge.value, 0.0);
  EXPECT_EQ(find(all, "ovws_wavefront_rms_waves"), nullptr);
  EXPECT_EQ(find(all, "ovws_wavefront_coefficient_waves"), nullptr);
}

TEST(Families, ReadMessagesOfOtherDaemonsWithoutHarm) {
  EXPECT_GT(families(json::object(), json::object()).size(), 1U);
  const json whole = example("stream.status");
  const json wavefront = example("stream.wavefront");
  for (const json& odd : {json(nullptr), json("x"), json(-1), json(1e300), json::array({"x"}),
                          json{{"x", {{"since_start", {{"count", 1}}}}}}}) {
    for (const auto& [key, value] : whole.items()) {
      json status = whole;
      status[key] = odd;
      EXPECT_FALSE(families(status, wavefront).empty()) << key << odd;
    }
    for (const auto& [key, value] : wavefront.items()) {
      json changed = wavefront;
      changed[key] = odd;
      EXPECT_FALSE(families(whole, changed).empty()) << key << odd;
    }
  }
}

TEST(Exporter, ListensOnLoopbackAddressesOnly) {
  for (const char* address : {"127.0.0.1:7705", "127.1.2.3:1", "[::1]:7705"}) {
    EXPECT_TRUE(check_address(address)) << address;
  }
  for (const char* address : {"", "7705", "127.0.0.1", "127.0.0.1:0", "0.0.0.0:7705", "*:7705",
                              "localhost:7705", "10.0.0.1:7705", "[::]:7705", "127.0.0.1:7705,1"}) {
    const auto refused = check_address(address);
    ASSERT_FALSE(refused) << address;
    EXPECT_EQ(refused.error().field, "--listen");
  }
}

TEST(Exporter, AnswersRequestsThatAddressThisMachineOnly) {
  for (const char* host : {"127.0.0.1:7705", "127.0.0.1", "localhost", "localhost:9000",
                           "[::1]:7705", "[::1]", "127.1.2.3:1"}) {
    EXPECT_TRUE(is_host_of_this_machine(host)) << host;
  }
  for (const char* host :
       {"", ":7705", "rebound.example.org:7705", "rebound.example.org", "localhost.example.org",
        "127.0.0.1.example.org:7705", "10.0.0.1:7705", "[::2]:7705", "[::]"}) {
    EXPECT_FALSE(is_host_of_this_machine(host)) << host;
  }
}

}  // namespace
}  // namespace ovws::metrics
