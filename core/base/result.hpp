/// Result<T>: a value or an Error. Used for failures that the caller can cause or must react to.
#pragma once

#include <optional>
#include <string>
#include <tl/expected.hpp>
#include <utility>

namespace ovws {

/// Error codes. Each code stands for what the caller should do next, whatever the cause.
enum class Errc {
  invalid,      ///< the value given is wrong: correct it and repeat the request
  refused,      ///< the value is valid, but the state does not allow it: change the state first
  unavailable,  ///< a device or a resource is missing: wait, or connect it
  device,       ///< a device failed or answered wrongly while it was in use
  internal,     ///< a bug in this program; reported, never hidden
};

/// Error report: what went wrong, in words that let a person fix the problem.
struct Error {
  Errc code = Errc::internal;
  std::string field;   ///< the setting at fault, as a dotted path ("camera.gain_db"); empty if none
  std::string reason;  ///< what was wrong and what to do, one sentence
  std::optional<double> min{}, max{};  ///< limits of a value out of range, in the field's unit
  std::string nearest{};  ///< closest valid name for an unknown one; empty if none is close
};

template <class T>
using Result = tl::expected<T, Error>;

/// Error text: "field: reason", or only the reason if the field is empty.
inline std::string text_of(const Error& error) {
  return error.field.empty() ? error.reason : error.field + ": " + error.reason;
}

/// Whether a retry is pointless until a person changes a value or the state.
inline bool needs_intervention(const Error& error) {
  return error.code == Errc::invalid || error.code == Errc::refused;
}

/// An error that converts to any Result: `return fail(Errc::invalid, "camera.gain_db", "…");`
[[nodiscard]] inline tl::unexpected<Error> fail(Errc code, std::string field, std::string reason) {
  return tl::make_unexpected(Error{code, std::move(field), std::move(reason)});
}
[[nodiscard]] inline tl::unexpected<Error> fail(Error error) {
  return tl::make_unexpected(std::move(error));
}

}  // namespace ovws
