/// Measurements as items of the library: the file of each kind, and how stored items are loaded.
#pragma once

#include <algorithm>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "daemon/ovwsd/library/calibration.hpp"
#include "daemon/ovwsd/library/library.hpp"
#include "daemon/ovwsd/library/measured_registration.hpp"
#include "daemon/ovwsd/library/origin.hpp"
#include "daemon/ovwsd/library/reference.hpp"
#include "daemon/ovwsd/library/slm_measured.hpp"
#include "daemon/shared/encoding.hpp"
#include "proto/json_text.hpp"

namespace ovws {

/// Kind, file name and file content of a type of measurements. Of items with equal names, only one
/// can be active: it overwrites the other one's file.
template <class T>
struct ItemOf;
template <>
struct ItemOf<Reference> {
  static constexpr const ItemKind& kKind = kReferenceItems;
  static constexpr auto encode = reference_content;
  static constexpr auto decode = reference_from;
  static std::string name(const Reference& one) { return identity_of(*one.origin); }
};
template <>
struct ItemOf<Calibration> {
  static constexpr const ItemKind& kKind = kCalibrationItems;
  static constexpr auto encode = calibration_content;
  static constexpr auto decode = calibration_from;
  static std::string name(const Calibration& one) {
    const std::string registration = json_text(one.origin->at("registration"));
    return sha256_hex(identity_of(*one.origin) + registration).substr(0, 16);
  }
};
template <>
struct ItemOf<MeasuredRegistration> {
  static constexpr const ItemKind& kKind = kRegistrationItems;
  static constexpr auto encode = registration_content;
  static constexpr auto decode = registration_from;
  static std::string name(const MeasuredRegistration&) { return "camera"; }
};
template <>
struct ItemOf<MeasuredLut> {
  static constexpr const ItemKind& kKind = kLutItems;
  static constexpr auto encode = lut_content;
  static constexpr auto decode = lut_from;
  static std::string name(const MeasuredLut&) { return "slm"; }
};
template <>
struct ItemOf<MeasuredFlatness> {
  static constexpr const ItemKind& kKind = kFlatnessItems;
  static constexpr auto encode = flatness_content;
  static constexpr auto decode = flatness_from;
  static std::string name(const MeasuredFlatness&) { return "slm"; }
};

/// The measurement as an item to be stored.
template <class T>
Library::Item item_of(const T& one) {
  using Of = ItemOf<T>;
  return {&Of::kKind, Of::name(one), one.t_taken_ns, Of::encode(one),
          title_of(Of::kKind, one.t_taken_ns)};
}
/// Checksum of the measurement's file; empty: it is not stored.
template <class T>
std::string sha256_of(const Library& library, const T& one) {
  return library.sha256(ItemOf<T>::kKind, ItemOf<T>::name(one));
}

template <class T>
using Shared = std::vector<std::shared_ptr<const T>>;  ///< oldest first

/// Judgement of a stored item: why it is not used (empty: it is used), and whether it is kept all
/// the same, because it will be used when the bench is as it was.
struct Judgement {
  std::string obstacle;
  bool waits = false;
};
/// Loads the items of a type that are used or wait. An event reports each file.
template <class T>
Shared<T> load_items(Library& library, const std::function<Judgement(T&)>& judge) {
  using Of = ItemOf<T>;
  Shared<T> all;
  library.load(Of::kKind, [&](const StateItem& file) -> Result<void> {
    auto item = Of::decode(file.content);
    if (!item) return fail(item.error());
    const Judgement judged = file.name == Of::name(*item)
                                 ? judge(*item)
                                 : Judgement{
                                       "its file name does not match its content: it was copied, "
                                       "or is of another version of the program"};
    library.publish_loaded(Of::kKind, file.name, item->t_taken_ns, judged.obstacle);
    if (judged.obstacle.empty() || judged.waits) {
      all.push_back(std::make_shared<const T>(std::move(*item)));
    }
    return {};
  });
  std::stable_sort(all.begin(), all.end(),
                   [](const auto& a, const auto& b) { return a->t_taken_ns < b->t_taken_ns; });
  return all;
}

}  // namespace ovws
