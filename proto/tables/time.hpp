/// Time fields: nanoseconds since the UNIX epoch, and the same time as ISO 8601 text.
#pragma once

#include <cstdint>
#include <string>

#include "proto/field.hpp"

namespace ovws {

/// ISO 8601 text of a UTC time: "2026-01-31T12:00:00.000Z".
std::string utc_text(std::int64_t t_ns);

inline constexpr const char* kTimeMeaning = "UNIX epoch UTC, nanoseconds";
inline constexpr const char* kTimeTextMeaning = "the same time as text, ISO 8601";

/// A computed field `key` with the time of `member` as text.
template <class S>
constexpr auto time_text(const char* key, std::int64_t S::*member) {
  return computed(
      key, [member](const S& from) { return utc_text(from.*member); }, kTimeTextMeaning);
}

}  // namespace ovws
