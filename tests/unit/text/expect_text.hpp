/// Texts that must contain others.
#pragma once

#include <gtest/gtest.h>

#include <string>

namespace ovws::cli {

inline void expect_text(const std::string& text, const std::string& part) {
  EXPECT_NE(text.find(part), std::string::npos) << text;
}

}  // namespace ovws::cli
