/// Sanitises text from devices and files for logs, terminals and messages.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace ovws {

/// Maximum bytes of a name that a device reports; GigE Vision allows 32.
inline constexpr std::size_t kMaxNameBytes = 64;

/// `text` as valid UTF-8 of at most `max_bytes` bytes; `max_bytes` must be at least 3. Each
/// control, zero-width, bidirectional and line-separator character and each invalid byte becomes
/// "?". A longer text is truncated and ends with "...".
std::string printable(std::string_view text, std::size_t max_bytes);

}  // namespace ovws
