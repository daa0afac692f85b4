/// One finding of many, and what it must be.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <ostream>
#include <string>

#include "daemon/examine/machine/finding.hpp"

namespace ovws::doctor {

inline void PrintTo(Verdict verdict, std::ostream* out) {
  constexpr const char* kNames[] = {"ok", "warning", "fault", "not here"};
  *out << kNames[int(verdict)];
}

/// The finding of that name, which must be there once. Any that asks for an act must say which.
inline Finding named(const Findings& findings, const std::string& name) {
  for (const Finding& one : findings) {
    const bool needs_fix = one.verdict == Verdict::warning || one.verdict == Verdict::fault;
    EXPECT_FALSE(one.meaning.empty()) << one.name;
    EXPECT_TRUE(!needs_fix || !one.fix.empty()) << one.name;
    EXPECT_TRUE(one.verdict != Verdict::ok || one.fix.empty()) << one.name;
  }
  EXPECT_EQ(std::ranges::count(findings, name, &Finding::name), 1) << name;
  const auto found = std::ranges::find(findings, name, &Finding::name);
  return found != findings.end() ? *found : Finding{};
}

template <class Facts>
void expect(const Facts& facts, const std::string& name, Verdict verdict,
            const std::string& fix = {}) {
  const Finding found = named(judge(facts), name);
  EXPECT_EQ(found.verdict, verdict) << name << ": " << found.meaning;
  if (!fix.empty()) {
    EXPECT_NE(found.fix.find(fix), std::string::npos) << found.fix;
  }
}

}  // namespace ovws::doctor
