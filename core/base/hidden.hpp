/// Hidden<Impl>: owner of an implementation that only a source file defines. Move-only, and unlike
/// with a plain unique_ptr the owner needs no destructor of its own.
#pragma once

#include <memory>
#include <utility>

namespace ovws {

template <class Impl>
using Hidden = std::unique_ptr<Impl, void (*)(Impl*)>;

template <class Impl, class... Arguments>
Hidden<Impl> make_hidden(Arguments&&... arguments) {
  return {new Impl(std::forward<Arguments>(arguments)...), [](Impl* made) { delete made; }};
}

}  // namespace ovws
