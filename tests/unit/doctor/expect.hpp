/// One finding of many, and what it must be.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <ostream>
#include <string>

#include "daemon/examine/finding.hpp"

namespace ovws::examine {

inline void PrintTo(Severity severity, std::ostream* out) {
  *out << names_of(severity).shown;
}

/// The finding of that name, which must be there once. Any that asks for an act must say which.
inline Finding named(const Findings& findings, const std::string& name) {
  for (const Finding& one : findings) {
    const bool needs_fix = one.severity == Severity::warning || one.severity == Severity::bad;
    EXPECT_FALSE(one.text.empty()) << one.name;
    EXPECT_TRUE(!needs_fix || !one.fix.empty()) << one.name;
    EXPECT_TRUE(one.severity != Severity::good || one.fix.empty()) << one.name;
  }
  EXPECT_EQ(std::ranges::count(findings, name, &Finding::name), 1) << name;
  const auto found = std::ranges::find(findings, name, &Finding::name);
  return found != findings.end() ? *found : Finding{};
}

template <class Facts>
void expect(const Facts& facts, const std::string& name, Severity verdict,
            const std::string& fix = {}) {
  const Finding found = named(answers(facts), name);
  EXPECT_EQ(found.severity, verdict) << name << ": " << found.text;
  if (!fix.empty()) {
    EXPECT_NE(found.fix.find(fix), std::string::npos) << found.fix;
  }
}

}  // namespace ovws::examine
