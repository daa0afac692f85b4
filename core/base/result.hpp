/// Errors as values: what a caller outside this code base could have caused, or must react to.
#pragma once

#include <optional>
#include <string>
#include <tl/expected.hpp>
#include <utility>

namespace ovws {

/// One value per reaction of the caller, not per cause.
enum class Errc {
  invalid,      ///< the value given is wrong: mend it and ask again
  refused,      ///< the value is right, the present state does not allow it: change the state first
  unavailable,  ///< a device or a resource is not there: wait, or connect it
  device,       ///< a device answered wrongly or failed while it was used
  internal,     ///< our own bug; reported, never hidden
};

/// What went wrong, said so that a person can mend it.
struct Error {
  Errc code = Errc::internal;
  std::string field;   ///< the setting at fault, as a dotted path ("camera.gain_db"); empty if none
  std::string reason;  ///< what was wrong and what to do, one sentence
  std::optional<double> min{}, max{};  ///< of a value out of range: its limits, in the field's unit
  std::string
      nearest{};  ///< of an unknown name: the known one that was meant; empty if none is near
};

template <class T>
using Result = tl::expected<T, Error>;

/// Waiting does not help: somebody has to mend a value or a state first.
inline bool needs_a_person(const Error& error) {
  return error.code == Errc::invalid || error.code == Errc::refused;
}

/// `return fail(Errc::invalid, "camera.gain_db", "…");` converts to any Result.
[[nodiscard]] inline tl::unexpected<Error> fail(Errc code, std::string field, std::string reason) {
  return tl::make_unexpected(Error{code, std::move(field), std::move(reason)});
}
[[nodiscard]] inline tl::unexpected<Error> fail(Error error) {
  return tl::make_unexpected(std::move(error));
}

}  // namespace ovws
