/// JSON encoding and decoding of structs with field tables.
///
/// Encoding: NaN, infinities and empty optionals become null, an enumeration its name, Vec2 [x, y].
/// Decoding is strict (see ObjectReader): every fault names the dotted path of its key. Computed
/// and constant fields may be given, and are ignored.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <concepts>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "core/base/vec2.hpp"
#include "proto/field.hpp"
#include "proto/json_text.hpp"
#include "proto/reader.hpp"

namespace ovws {

using Json = nlohmann::json;

/// Wire format of a type whose JSON does not follow from a field table. A specialisation provides
/// to_json, decode and schema.
template <class T>
struct Wire;
struct SchemaParts;  // field_schema.hpp
template <class T>
concept HasWire = requires {
  sizeof(Wire<T>);
};

namespace detail {

template <class T>
inline constexpr bool is_named_list = false;  ///< a map: an object whose keys are data
template <class T>
inline constexpr bool is_named_list<std::vector<std::pair<std::string, T>>> = true;
template <class T>
concept TextLike = std::is_convertible_v<const T&, std::string_view>;
template <class T>
concept ListLike = requires(const T& list) {
  list.begin();
  list.end();
  list.size();
}
&&!TextLike<T>;

/// Whether a nullable field encodes this value as null: empty texts and arrays. NaN and empty
/// optionals become null in any field.
template <class T>
bool is_nothing(const T& value) {
  if constexpr (TextLike<T>) {
    return std::string_view(value).empty();
  } else if constexpr (ListLike<T> && !std::is_same_v<T, Json>) {
    return value.size() == 0;
  } else if constexpr (HasTable<T> && requires { value.empty(); }) {
    return value.empty();
  } else {
    return false;
  }
}

}  // namespace detail

template <class J = Json, class T>
J to_json(const T& value);

/// JSON that already has the fields of S, for example read from a file.
template <class S>
struct JsonOf {
  Json json;
};
template <class S>
struct Wire<JsonOf<S>> {
  static Json to_json(const JsonOf<S>& kept) { return kept.json; }
  static Json schema(SchemaParts& parts, const FieldInfo&);  // field_schema.hpp
};

/// JSON object without a field table. Its schema states only the type `object`.
struct JsonObject {
  Json json = Json::object();
};
template <>
struct Wire<JsonObject> {
  static Json to_json(const JsonObject& object) { return object.json; }
  static Json schema(SchemaParts&, const FieldInfo&) { return {{"type", "object"}}; }
};

namespace detail {

/// How a type is encoded. Fields are encoded through it, so that code is generated for each type
/// and not for each field.
template <class J>
struct Encoder {
  J (*encode)(const void* value);
  bool (*is_nothing)(const void* value);
};
template <class J, class T>
inline constexpr Encoder<J> kEncoder{
    [](const void* value) { return J(to_json<J>(*static_cast<const T*>(value))); },
    [](const void* value) { return is_nothing(*static_cast<const T*>(value)); }};

// Compiled once. J: as in to_json.
template <class J>
void put_field(J& out, const FieldInfo& field, const Encoder<J>& encoder, const void* value);
template <class J>
J number_or_null(double value);
template <class J>
J point(const Vec2& value);
template <class J>
J parsed(const char* json);

}  // namespace detail

/// Encodes the fields of `from` into the object `out`.
template <class J, HasTable S>
void put_fields(J& out, const S& from) {
  visit_fields(from, [&out](const FieldInfo& field, const auto& value) {
    using T = std::remove_cvref_t<decltype(value)>;
    detail::put_field(out, field, detail::kEncoder<J, T>, &value);
  });
}

/// Encodes a value. J: Json, or nlohmann::ordered_json for keys in the table's order.
template <class J, class T>
J to_json(const T& value) {
  using namespace detail;
  if constexpr (HasWire<T>) {
    return Wire<T>::to_json(value);
  } else if constexpr (std::is_same_v<T, Absent>) {
    return parsed<J>(value.json);
  } else if constexpr (is_optional<T>) {
    return value ? to_json<J>(*value) : J();
  } else if constexpr (std::is_floating_point_v<T>) {
    return number_or_null<J>(value);
  } else if constexpr (std::is_enum_v<T>) {
    return kNames<T>()[std::size_t(value)];
  } else if constexpr (std::is_same_v<T, Vec2>) {
    return point<J>(value);
  } else if constexpr (HasTable<T>) {
    J out = J::object();
    put_fields(out, value);
    return out;
  } else if constexpr (is_named_list<T>) {
    J out = J::object();
    for (const auto& [key, one] : value) out[key] = to_json<J>(one);
    return out;
  } else if constexpr (std::is_same_v<T, Json> || std::is_arithmetic_v<T>) {
    return value;
  } else if constexpr (TextLike<T>) {
    return std::string(std::string_view(value));
  } else {
    static_assert(ListLike<T>, "this type has no form on the wire");
    J out = J::array();
    for (const auto& one : value) out.push_back(to_json<J>(one));
    return out;
  }
}

/// Copy of `object` with only those keys that are fields of S.
template <HasTable S>
Json only_fields(const Json& object) {
  Json out = Json::object();
  visit_fields(S{}, [&](const FieldInfo& field, const auto&) {
    if (object.contains(field.key)) out[field.key] = object[field.key];
  });
  return out;
}

namespace detail {

inline constexpr std::size_t kMaxElements = 10000;

template <class T>
void decode_value(ObjectReader& reader, const FieldInfo& field, T& out);

/// The part of `bounds` that T can hold.
template <class T>
Bounds bounds_in(const Bounds& bounds) {
  if constexpr (std::is_integral_v<T>) {
    constexpr double kMax64 = 9223372036854774784.0;  // the largest double below 2^63
    constexpr double kMin = std::max(double(std::numeric_limits<T>::min()), -kMax64);
    constexpr double kMax = std::min(double(std::numeric_limits<T>::max()), kMax64);
    return {std::clamp(bounds.min, kMin, kMax), std::clamp(bounds.max, kMin, kMax)};
  } else {
    return bounds;
  }
}

/// Decodes an array of numbers, which must be whole if T is an integer.
template <class T>
void decode_numbers(ObjectReader& reader, const FieldInfo& field, std::vector<T>& out) {
  std::vector<double> given;
  const Bounds bounds = bounds_in<T>(field.bounds);
  reader.numbers(field.key, given, field.min_size, std::min(field.max_size, kMaxElements),
                 bounds.min, bounds.max);
  if (!reader.has(field.key) || reader.failed()) return;
  std::vector<T> read;
  for (const double value : given) {
    if (std::is_integral_v<T> && value != std::floor(value)) {
      return reader.fault(field.key, "must be whole numbers");
    }
    if (field.distinct && std::find(read.begin(), read.end(), T(value)) != read.end()) {
      return reader.fault(field.key, json_text(Json(T(value))) + " is given twice");
    }
    read.push_back(T(value));
  }
  out = std::move(read);
}

/// Decodes an array of exactly `size` numbers and passes them to `put`.
template <class Put>
void decode_tuple(ObjectReader& reader, const FieldInfo& field, std::size_t size, Put put) {
  std::vector<double> given;
  reader.numbers(field.key, given, size, size, field.bounds.min, field.bounds.max);
  if (given.size() == size) put(given);
}

/// Decodes an array of pairs [x, y].
void decode_points(ObjectReader& reader, const FieldInfo& field, std::vector<Vec2>& out);

template <HasTable S>
void decode_fields(ObjectReader& reader, S& out);

/// Decodes an array whose elements have their own T::decode.
template <class T>
void decode_each(ObjectReader& reader, const FieldInfo& field, std::vector<T>& out) {
  const Json* const given = reader.raw(field.key);
  if (given == nullptr || reader.failed()) return;
  if (!given->is_array() || given->size() < field.min_size || given->size() > field.max_size) {
    return reader.fault(field.key, "must be an array of " + std::to_string(field.min_size) +
                                       " to " + std::to_string(field.max_size) + " objects");
  }
  std::vector<T> read;
  for (std::size_t k = 0; k < given->size(); ++k) {
    auto one = T::decode((*given)[k]);
    if (!one) {
      const std::string& inner = one.error().field;
      return reader.fault(std::string(field.key) + "[" + std::to_string(k) + "]" +
                              (inner.empty() ? "" : ".") + inner,
                          one.error().reason);
    }
    read.push_back(std::move(*one));
  }
  out = std::move(read);
}

template <class T>
void decode_list(ObjectReader& reader, const FieldInfo& field, std::vector<T>& out) {
  std::vector<T> read;
  reader.objects(field.key, std::min(field.max_size, kMaxElements),
                 [&](ObjectReader& inner, std::size_t) {
                   T one{};
                   decode_fields(inner, one);
                   if constexpr (std::equality_comparable<T>) {
                     const bool repeated = std::find(read.begin(), read.end(), one) != read.end();
                     if (field.distinct && repeated && !inner.failed()) {
                       inner.fault("", "is given twice");
                     }
                   }
                   read.push_back(std::move(one));
                 });
  if (!reader.has(field.key) || reader.failed()) return;
  if (read.size() < field.min_size) {
    return reader.fault(field.key,
                        "must have at least " + std::to_string(field.min_size) + " elements");
  }
  out = std::move(read);
}

template <class T>
void decode_value(ObjectReader& reader, const FieldInfo& field, T& out) {
  const char* const key = field.key;
  const Bounds bounds = bounds_in<T>(field.bounds);
  if constexpr (!HasWire<T> && !is_optional<T>) {
    // Null leaves the value unchanged: reports contain null for a missing value and may be sent
    // back.
    if (field.nullable && reader.is_null(key)) return;
  }
  if constexpr (HasWire<T>) {
    Wire<T>::decode(reader, field, out);
  } else if constexpr (std::is_same_v<T, bool>) {
    reader.boolean(key, out);
  } else if constexpr (std::is_integral_v<T>) {
    if constexpr (sizeof(T) > sizeof(int)) {
      reader.integer(key, out, bounds.min, bounds.max);
    } else {
      reader.integer(key, out, int(bounds.min), int(bounds.max));
    }
  } else if constexpr (std::is_floating_point_v<T>) {
    reader.number(key, out, bounds.min, bounds.max);
  } else if constexpr (std::is_same_v<T, std::string>) {
    reader.string(key, out);
  } else if constexpr (std::is_enum_v<T>) {
    int value = int(out);
    reader.choice(key, value, (field.names != nullptr ? field.names : kNames<T>)());
    out = T(value);
  } else if constexpr (is_optional<T>) {
    typename T::value_type given{};
    if (reader.is_null(key)) return out.reset();
    decode_value(reader, field, given);
    if (reader.has(key) && !reader.failed()) out = std::move(given);
  } else if constexpr (std::is_same_v<T, Vec2> || std::is_same_v<T, std::array<double, 2>>) {
    decode_tuple(reader, field, 2, [&out](const auto& given) { out = {given[0], given[1]}; });
  } else if constexpr (HasTable<T>) {
    reader.object(key, [&out](ObjectReader& inner) { decode_fields(inner, out); });
  } else if constexpr (std::is_same_v<T, std::vector<Vec2>>) {
    decode_points(reader, field, out);
  } else if constexpr (requires { T::value_type::decode(Json()); }) {
    decode_each(reader, field, out);
  } else if constexpr (HasTable<typename T::value_type>) {
    decode_list(reader, field, out);
  } else {
    decode_numbers(reader, field, out);
  }
}

template <class Owner>
void decode_entry(ObjectReader& reader, const FieldInfo& encode_only, Owner&) {
  reader.raw(encode_only.key);
}
template <class Owner, class S, class T>
void decode_entry(ObjectReader& reader, const Field<S, T>& field, Owner& out) {
  if (field.required) reader.require(field.key);
  decode_value(reader, field, out.*field.member);
  if (field.check == nullptr || reader.failed()) return;
  if (auto wrong = field.check(out.*field.member)) reader.fault(field.key, std::move(*wrong));
}
template <class Owner, class T>
void decode_entry(ObjectReader& reader, const Based<T>&, Owner& out) {
  decode_fields(reader, static_cast<T&>(out));
}
template <class Owner, class S, class T>
void decode_entry(ObjectReader& reader, const Inlined<S, T>& entry, Owner& out) {
  decode_fields(reader, out.*entry.member);
}

template <HasTable S>
void decode_fields(ObjectReader& reader, S& out) {
  kTable<S>.apply([&](const auto&... entry) { (decode_entry(reader, entry, out), ...); });
  if constexpr (requires { Rules<S>::check(out, reader); }) {
    if (!reader.failed()) Rules<S>::check(out, reader);
  }
}

}  // namespace detail

/// Decodes a JSON object strictly. Fields whose keys are missing keep their values from `base`.
/// Errors: Errc::invalid; any fault discards the whole result.
template <HasTable S>
Result<S> decode(const Json& object, S base = {}) {
  ObjectReader reader(object, "");
  detail::decode_fields(reader, base);
  if (auto done = reader.finish(); !done) return fail(done.error());
  return base;
}

namespace detail {

template <class S, class T>
T value_of(T S::*member);

/// JSON key of a struct member, searched in the field table and in the tables of inlined members;
/// nullptr if the member has no key.
template <class S, class T, class Member>
const char* key_of_entry(const Field<S, T>& entry, Member member) {
  if constexpr (std::is_same_v<decltype(entry.member), Member>) {
    return entry.member == member ? entry.key : nullptr;
  } else {
    return nullptr;
  }
}
template <class S, class Member>
const char* key_in_table(Member member) {
  const char* key = nullptr;
  const auto find_key = [&](const auto& entry) {
    if (key != nullptr) return;
    if constexpr (requires { key_of_entry(entry, member); }) {
      key = key_of_entry(entry, member);
    } else if constexpr (requires { entry.member; }) {
      key = key_in_table<std::remove_cvref_t<decltype(value_of(entry.member))>>(member);
    }
  };
  kTable<S>.apply([&](const auto&... entry) { (find_key(entry), ...); });
  return key;
}

}  // namespace detail

/// A partial update of a struct: fields that are not given stay unchanged.
template <HasTable S>
class Partial {
 public:
  Partial() = default;
  /// Decodes a change strictly. With `"clamp": true` a number out of range becomes the nearest
  /// limit. Errors: as in `decode`, except those that depend on the values of other fields.
  static Result<Partial> decode(Json object) {
    Partial partial;
    ObjectReader reader(object, "");
    reader.boolean("clamp", partial.clamp_);
    S checked{};
    reader.clamp(partial.clamp_);
    detail::decode_fields(reader, checked);
    if constexpr (requires { Rules<S>::check_change(reader); }) Rules<S>::check_change(reader);
    if (auto done = reader.finish(); !done) return fail(done.error());
    object.erase("clamp");
    partial.given_ = std::move(object);
    return partial;
  }

  /// The change that turns `before` into `after`.
  static Partial difference(const S& before, const S& after) {
    const Json then = to_json(before), now = to_json(after);
    Partial partial;
    for (const auto& [key, value] : now.items()) {
      if (then.at(key) != value) partial.given_[key] = value;
    }
    return partial;
  }
  /// The change that sets every field as in `all`.
  static Partial whole(const S& all) {
    Partial partial;
    partial.given_ = to_json(all);
    return partial;
  }

  /// A member without a key in the table of S is a fault of the caller: std::logic_error.
  template <class Member>
  void put(Member member, const auto& value) {
    given_[key_of(member)] = to_json(value);
  }
  template <class Member>
  void forget(Member member) {
    given_.erase(key_of(member));
  }
  /// Whether the change sets `member`. A null counts as set only if the member is an optional.
  template <class Member>
  bool gives(Member member) const {
    const auto found = given_.find(key_of(member));
    if (found == given_.end()) return false;
    return detail::is_optional<decltype(detail::value_of(member))> || !found->is_null();
  }
  bool clamp() const { return clamp_; }
  void set_clamp(bool on) { clamp_ = on; }
  const Json& given() const { return given_; }  ///< without `clamp`

  S applied_to(S base) const {
    if constexpr (requires { Rules<S>::begin_change(base, given_); }) {
      Rules<S>::begin_change(base, given_);
    }
    ObjectReader reader(given_, "");
    reader.clamp(clamp_);
    detail::decode_fields(reader, base);
    return base;
  }

 private:
  template <class Member>
  static const char* key_of(Member member) {
    const char* const key = detail::key_in_table<S>(member);
    if (key == nullptr) throw std::logic_error("a change sets a member that has no key");
    return key;
  }

  Json given_ = Json::object();
  bool clamp_ = false;
};

/// Encodes a change as the keys that it sets, without `clamp`.
template <class S>
struct Wire<Partial<S>> {
  static Json to_json(const Partial<S>& change) { return change.given(); }
  static Json schema(SchemaParts& parts, const FieldInfo&);  // field_schema.hpp
};

/// Decodes the params of a method with P::decode if that exists, else with the field table of P.
template <class P>
Result<P> decode_params(const Json& params) {
  if constexpr (requires { P::decode(params); }) {
    return P::decode(params);
  } else {
    return decode<P>(params);
  }
}

}  // namespace ovws
