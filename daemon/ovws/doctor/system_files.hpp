/// Readers of the kernel's files in /proc and /sys.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

namespace ovws::doctor {

/// The whole file; none: it does not exist or cannot be read.
std::optional<std::string> text_of(const std::string& path);
/// Its first word; none also if it is empty.
std::optional<std::string> word_of(const std::string& path);
/// Its first word as a whole number; none also if it is not a number.
std::optional<std::int64_t> number_of(const std::string& path);

}  // namespace ovws::doctor
