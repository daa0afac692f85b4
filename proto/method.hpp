/// What describes a control method and a stream: names, types, text.
#pragma once

namespace ovws {

/// A control method with params P and result R.
template <class P, class R>
struct Method {
  using Params = P;
  using Result = R;
  const char* name;
  const char* description;
  const char* binary_params = nullptr;  ///< meaning of the request's binary frame; null: none
  const char* binary_result = nullptr;  ///< meaning of the reply's binary frame; null: none

  constexpr Method taking(const char* binary) const {
    return {name, description, binary, binary_result};
  }
  constexpr Method giving(const char* binary) const {
    return {name, description, binary_params, binary};
  }
};
template <class P, class R>
constexpr Method<P, R> method(const char* name, const char* description) {
  return {name, description};
}

/// A stream topic; M is the JSON part of its messages.
template <class M>
struct Stream {
  using Message = M;
  const char* topic;
  const char* description;
};
template <class M>
constexpr Stream<M> stream(const char* topic, const char* description) {
  return {topic, description};
}

}  // namespace ovws
