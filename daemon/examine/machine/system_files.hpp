/// Readers of the kernel's files in /proc and /sys.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

namespace ovws::doctor {

/// Whole text of the file; none: the file does not exist or cannot be read.
std::optional<std::string> text_of(const std::string& path);
/// First word of the file; none: the file is empty or cannot be read.
std::optional<std::string> word_of(const std::string& path);
/// First word of the file as a whole number; none: it is no number, or the file cannot be read.
std::optional<std::int64_t> number_of(const std::string& path);

}  // namespace ovws::doctor
