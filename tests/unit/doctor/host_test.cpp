#include "daemon/examine/machine/machine.hpp"

#include "daemon/examine/machine/machine.hpp"
#include "tests/unit/doctor/expect.hpp"

namespace ovws::examine {
namespace {

constexpr const char* kLimits =
    "Limit                     Soft Limit           Hard Limit           Units     \n"
    "Max locked memory         8388608              unlimited            bytes     \n"
    "Max realtime priority     20                   90                             \n";

HostFacts tuned() {
  HostFacts facts;
  facts.limits = Limits{90, std::nullopt, false, false};
  facts.rt_runtime_us = 950000;
  facts.rt_period_us = 1000000;
  facts.governors = {"performance"};
  facts.dma_latency = Access::given;
  facts.clock_source = "tsc";
  facts.clock_synchronised = true;
  return facts;
}

TEST(SystemFiles, TheTextIsWholeAndAReadErrorIsNoText) {
  EXPECT_EQ(text_of("/dev/null"), "");
  EXPECT_EQ(text_of("/proc/self/comm"), *word_of("/proc/self/comm") + "\n");
  EXPECT_EQ(text_of("/"), std::nullopt);
  EXPECT_EQ(text_of("/nonexistent"), std::nullopt);
}

TEST(DoctorHost, ATunedHostHasNoFinding) {
  for (const Finding& one : answers(tuned())) EXPECT_EQ(one.severity, Severity::good) << one.text;
}

TEST(DoctorHost, AHostWithoutFactsIsNotJudged) {
  for (const Finding& one : answers(HostFacts{})) {
    EXPECT_EQ(one.severity, Severity::not_here) << one.text;
  }
}

TEST(DoctorHost, WhatIsMissingForRealTimeIsAFaultOnlyWhereItIsEnforced) {
  auto facts = tuned();
  facts.limits = Limits{79, 8 << 20, false, false};  // `acquire` has 80
  facts.rt_runtime_us = 500000;
  facts.dma_latency = Access::refused;
  for (const auto& [policy, verdict] : {std::pair{RealtimePolicy::ignore, Severity::warning},
                                        std::pair{RealtimePolicy::enforce, Severity::bad}}) {
    facts.policy = policy;
    expect(facts, "realtime.priority", verdict, "rtprio 90");
    expect(facts, "realtime.memory", verdict, "memlock unlimited");
    expect(facts, "realtime.throttling", verdict, "sched_rt_runtime_us=950000");
    expect(facts, "cpu.sleep", verdict, "sudo systemctl start ovwsd");
  }
  facts.of_service = true;
  expect(facts, "realtime.priority", Severity::bad, "systemctl revert ovwsd");
  expect(facts, "cpu.sleep", Severity::not_here);
  facts.limits = Limits{80, std::nullopt, false, false};
  expect(facts, "realtime.priority", Severity::good);
  facts.limits = Limits{0, 0, true, true};  // root
  expect(facts, "realtime.priority", Severity::good);
  expect(facts, "realtime.memory", Severity::good);
  facts.rt_runtime_us = -1;
  expect(facts, "realtime.throttling", Severity::good);
}

TEST(DoctorHost, ProcessorsAndClock) {
  auto facts = tuned();
  facts.governors = {"performance", "powersave"};
  expect(facts, "cpu.governor", Severity::warning, "scaling_governor");
  facts.clock_source = "hpet";
  expect(facts, "clock.source", Severity::warning, "echo tsc");
  facts.clock_synchronised = false;
  expect(facts, "clock.synchronised", Severity::warning, "timedatectl set-ntp true");
}

TEST(DoctorHost, LimitsAreReadAsTheKernelWritesThem) {
  const auto user = parse_limits(kLimits, "Name:\tovwsd\nCapEff:\t0000000000000000\n");
  ASSERT_TRUE(user);
  EXPECT_EQ(user->realtime_priority, 20U);
  EXPECT_EQ(user->locked_bytes, 8388608U);
  EXPECT_FALSE(user->may_any_priority || user->may_lock_all);
  const auto root = parse_limits(
      "Max locked memory         unlimited            unlimited            bytes     \n"
      "Max realtime priority     unlimited            unlimited                      \n",
      "CapEff:\t0000000000804000\n");
  ASSERT_TRUE(root);
  EXPECT_FALSE(root->locked_bytes);
  EXPECT_GE(root->realtime_priority, 80U);
  EXPECT_TRUE(root->may_any_priority);
  EXPECT_TRUE(root->may_lock_all);
  EXPECT_FALSE(parse_limits("", "CapEff:\t0\n"));
  EXPECT_FALSE(parse_limits(kLimits, "Name:\tovwsd\n"));
}

}  // namespace
}  // namespace ovws::examine
