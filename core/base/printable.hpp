/// Text of a device or a file, made fit for a log, a terminal and a message.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace ovws {

/// Bytes of one name that a device gives: GigE Vision has at most 32.
inline constexpr std::size_t kMaxNameBytes = 64;

/// `text` as UTF-8 of at most `max_bytes` bytes, at least 3. Each control character, character that
/// changes the direction or the line of what follows, and byte that is no UTF-8 is replaced by "?";
/// a longer text ends with "...".
std::string printable(std::string_view text, std::size_t max_bytes);

}  // namespace ovws
