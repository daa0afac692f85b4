/// Hidden<Impl>: pointer to an implementation class that only a source file defines (pimpl).
/// Move-only. It stores its deleter, so the class that holds it needs no destructor of its own.
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
