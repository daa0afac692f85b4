/// Sanitises text from devices and files for logs, terminals and messages.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace ovws {

/// Maximum bytes of a name that a device reports; GigE Vision allows 32.
inline constexpr std::size_t kMaxNameBytes = 64;

/// Returns `text` as valid UTF-8 of at most `max_bytes` bytes, which must be at least 3. Each
/// control, zero-width, bidirectional or line-separator character and each invalid byte becomes
/// "?". Text that does not fit is truncated and ends with "...".
std::string printable(std::string_view text, std::size_t max_bytes);

}  // namespace ovws
