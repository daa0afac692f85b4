/// Field tables: compile-time descriptions of the structs on the wire and in the configuration
/// file. A table lists key, member, range and meaning of each field. JSON encoding and strict
/// decoding (field_json.hpp) and JSON Schemas (field_schema.hpp) are generated from it.
///
///     template <>
///     inline constexpr auto kTable<Roi> = Fields{
///         "Roi", field<&Roi::x>("left edge, sensor pixels", limits::kRoiOffset), …};
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "proto/limits.hpp"

namespace ovws {

/// Inclusive range of a number, or of each number of an array.
struct Bounds {
  double min = -std::numeric_limits<double>::infinity();
  double max = std::numeric_limits<double>::infinity();

  constexpr Bounds() = default;
  constexpr Bounds(double lowest, double highest) : min(lowest), max(highest) {}
  constexpr Bounds(limits::Numbers range) : min(range.min), max(range.max) {}
  constexpr Bounds(limits::Integers range) : min(range.min), max(range.max) {}
  static constexpr Bounds at_least(double lowest) {
    return {lowest, std::numeric_limits<double>::infinity()};
  }
};

using NamesOf = const std::vector<std::string>& (*)();

/// A string literal as a template argument.
template <std::size_t N>
struct Literal {
  char text[N];
  consteval Literal(const char (&literal)[N]) { std::copy_n(literal, N, text); }
};

/// List of the template arguments as texts.
template <Literal... kTexts>
const std::vector<std::string>& texts() {
  static const std::vector<std::string> all{kTexts.text...};
  return all;
}

namespace detail {

template <class E>
const std::vector<std::string>& names_are_missing() {
  static_assert(sizeof(E) == 0, "specialise kNames for this enumeration");
  return texts<>();
}

}  // namespace detail

/// Names of an enumeration on the wire, in the order of its values. Specialise it for each
/// enumeration.
template <class E>
inline constexpr NamesOf kNames = detail::names_are_missing<E>;
template <class E>
std::string_view wire_name(E value) {
  return kNames<E>()[std::size_t(value)];
}

/// Properties of a field besides its type.
struct FieldInfo {
  const char* key = "";
  const char* meaning = "";  ///< description with the unit, for documentation and schemas
  Bounds bounds{};
  std::size_t min_size = 0, max_size = std::numeric_limits<std::size_t>::max();  ///< array length
  bool nullable = false;        ///< NaN, empty texts and empty arrays are encoded as null
  bool left_out = false;        ///< the key is omitted where nullable would give null
  bool required = false;        ///< params: the key must be given, there is no default
  bool distinct = false;        ///< array: values must be unique
  bool nulls = false;           ///< array: numbers may be NaN, encoded as null
  NamesOf names = nullptr;      ///< allowed values of a text, or allowed keys of an object
  const char* absent = "null";  ///< JSON text if the inlined optional is empty; see Inlined
};

/// Modifiers of a field declaration; each returns a changed copy.
template <class Self>
struct Described : FieldInfo {
  constexpr Self or_null() const {
    return with([](Self& f) { f.nullable = true; });
  }
  constexpr Self or_left_out() const {
    return with([](Self& f) { f.left_out = true; });
  }
  constexpr Self sized(std::size_t min_count, std::size_t max_count) const {
    return with([=](Self& f) { f.min_size = min_count, f.max_size = max_count; });
  }
  constexpr Self with_nulls() const {
    return with([](Self& f) { f.nulls = true; });
  }
  constexpr Self among(NamesOf all) const {
    return with([=](Self& f) { f.names = all; });
  }
  constexpr Self if_absent(const char* value) const {
    return with([=](Self& f) { f.absent = value; });
  }

 protected:
  template <class Change>
  constexpr Self with(Change change) const {
    Self out = static_cast<const Self&>(*this);
    change(out);
    return out;
  }
};

/// Additional check of a value that has the right type and range. Returns why the value is wrong,
/// or none.
template <class T>
using FieldCheck = std::optional<std::string> (*)(const T&);

template <class S, class T>
struct Field : Described<Field<S, T>> {
  T S::*member = nullptr;
  FieldCheck<T> check = nullptr;

  const T& of(const S& from) const { return from.*member; }

  constexpr Field mandatory() const {
    return this->with([](Field& f) { f.required = true; });
  }
  constexpr Field unlike() const {
    return this->with([](Field& f) { f.distinct = true; });
  }
  constexpr Field checked(FieldCheck<T> by) const {
    return this->with([=](Field& f) { f.check = by; });
  }
};

template <class S, class T>
constexpr auto field(const char* key, T S::*member, const char* meaning, Bounds bounds = {}) {
  Field<S, T> out;
  out.key = key;
  out.meaning = meaning;
  out.bounds = bounds;
  out.member = member;
  return out;
}

namespace detail {

/// The name of a member, NUL-terminated, from the compiler's text "… [… &ovws::Roi::x]".
template <auto kMember>
consteval auto name_of_member() {
  constexpr std::string_view text = __PRETTY_FUNCTION__;
  constexpr std::size_t end = text.rfind(']'), begin = text.rfind(':', end) + 1;
  std::array<char, end - begin + 1> name{};
  text.copy(name.data(), end - begin, begin);
  return name;
}
template <auto kMember>
inline constexpr auto kMemberName = name_of_member<kMember>();

}  // namespace detail

/// A field whose key is the member's name.
template <auto kMember>
constexpr auto field(const char* meaning, Bounds bounds = {}) {
  return field(detail::kMemberName<kMember>.data(), kMember, meaning, bounds);
}

/// Encode-only field whose value is computed by get(struct).
template <class Get>
struct Computed : Described<Computed<Get>> {
  Get get;

  constexpr explicit Computed(Get by) : get(by) {}
  template <class S>
  decltype(auto) of(const S& from) const {
    return get(from);
  }
};

template <class Get>
constexpr auto computed(const char* key, Get get, const char* meaning, Bounds bounds = {}) {
  Computed<Get> out(get);
  out.key = key;
  out.meaning = meaning;
  out.bounds = bounds;
  return out;
}

/// Encode-only field with a constant text.
struct Constant : FieldInfo {
  const char* text = "";
};

constexpr Constant constant(const char* key, const char* text, const char* meaning) {
  Constant out;
  out.key = key;
  out.meaning = meaning;
  out.text = text;
  return out;
}

/// Flattens a member: the member's fields appear among the struct's own fields. If the member is an
/// empty optional, each of its fields is encoded as null or as its `if_absent` text.
template <class S, class T>
struct Inlined {
  T S::*member;
};
template <class S, class T>
constexpr Inlined<S, T> inlined(T S::*member) {
  return {member};
}

/// Flattens a base class: its fields appear among the fields of the derived struct.
template <class T>
struct Based {};
template <class T>
constexpr Based<T> based() {
  return {};
}

/// Value of a field in an empty optional, as JSON text.
struct Absent {
  const char* json;
};

/// Entry number I of an EntryList.
template <std::size_t I, class Entry>
struct EntryAt {
  Entry entry;
};

template <class Indices, class... Entries>
struct IndexedEntries;
template <std::size_t... I, class... Entries>
struct IndexedEntries<std::index_sequence<I...>, Entries...> : EntryAt<I, Entries>... {
  constexpr explicit IndexedEntries(Entries... entries) : EntryAt<I, Entries>{entries}... {}

  template <class Visit>
  constexpr auto apply(Visit&& visit) const {
    return visit(static_cast<const EntryAt<I, Entries>&>(*this).entry...);
  }
};

/// Values of different types. It replaces std::tuple, which takes three times as long to compile:
/// every file that includes a message compiles its table.
template <class... Entries>
struct EntryList : IndexedEntries<std::index_sequence_for<Entries...>, Entries...> {
  static constexpr std::size_t kSize = sizeof...(Entries);

  constexpr explicit EntryList(Entries... entries)
      : IndexedEntries<std::index_sequence_for<Entries...>, Entries...>(entries...) {}
};

/// Field table of a struct: the struct's name in schemas, and the fields.
template <class... Entries>
struct Fields : EntryList<Entries...> {
  const char* name;

  constexpr explicit Fields(const char* in_schemas, Entries... entries)
      : EntryList<Entries...>(entries...), name(in_schemas) {}
};

/// Field table of a struct; nullptr if it has none. Specialise it for each struct on the wire.
template <class S>
inline constexpr auto kTable = nullptr;
template <class S>
concept HasTable = !std::is_same_v<decltype(kTable<S>), const std::nullptr_t>;

/// Rules between the fields of a struct. Specialise it for a struct whose fields depend on each
/// other, with any of these functions:
///
///     static void check(S&, ObjectReader&);               checks a decoded struct
///     static void check_change(ObjectReader&);            checks the keys of a Partial<S>
///     static void begin_change(S&, const Json& given);    prepares S for `given`
///     static Json schema();                               the rules in JSON Schema
template <class S>
struct Rules {};

namespace detail {

template <class T>
inline constexpr bool is_optional = false;
template <class T>
inline constexpr bool is_optional<std::optional<T>> = true;

template <class S, class Visit>
void visit_absent(Visit& visit);

template <class Visit>
void visit_absent_entry(const FieldInfo& entry, Visit& visit) {
  visit(entry, Absent{entry.absent});
}
template <class S, class T, class Visit>
void visit_absent_entry(const Inlined<S, T>&, Visit& visit) {
  visit_absent<T>(visit);
}
template <class S, class Visit>
void visit_absent(Visit& visit) {
  kTable<S>.apply([&](const auto&... entry) { (visit_absent_entry(entry, visit), ...); });
}

template <class S, class Entry, class Visit>
void visit_entry(const S& from, const Entry& entry, Visit& visit) {
  visit(entry, entry.of(from));
}
template <class S, class Visit>
void visit_entry(const S&, const Constant& entry, Visit& visit) {
  visit(entry, std::string_view(entry.text));
}
template <class Owner, class S, class T, class Visit>
void visit_entry(const Owner& from, const Inlined<S, T>& entry, Visit& visit);
template <class Owner, class T, class Visit>
void visit_entry(const Owner& from, const Based<T>& entry, Visit& visit);

}  // namespace detail

/// Calls visit(field, value) for every field of `from`, in the table's order. The value of a field
/// in an empty inlined optional is an Absent.
template <HasTable S, class Visit>
void visit_fields(const S& from, Visit&& visit) {
  kTable<S>.apply([&](const auto&... entry) { (detail::visit_entry(from, entry, visit), ...); });
}

template <class Owner, class T, class Visit>
void detail::visit_entry(const Owner& from, const Based<T>&, Visit& visit) {
  visit_fields(static_cast<const T&>(from), visit);
}

template <class Owner, class S, class T, class Visit>
void detail::visit_entry(const Owner& from, const Inlined<S, T>& entry, Visit& visit) {
  if constexpr (is_optional<T>) {
    const T& value = from.*entry.member;
    if (!value) return visit_absent<typename T::value_type>(visit);
    visit_fields(*value, visit);
  } else {
    visit_fields(from.*entry.member, visit);
  }
}

}  // namespace ovws
