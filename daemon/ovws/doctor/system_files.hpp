/// Reads what the kernel tells in files.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

namespace ovws::doctor {

/// The whole file; none: it is not there, or may not be read.
std::optional<std::string> text_of(const std::string& path);
/// Its first word; none also if it is empty.
std::optional<std::string> word_of(const std::string& path);
/// Its first word as a whole number; none also if it is no number.
std::optional<std::int64_t> number_of(const std::string& path);

}  // namespace ovws::doctor
