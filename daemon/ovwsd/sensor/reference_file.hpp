/// Content of reference files: reference positions and their mean image as JSON.
#pragma once

#include <nlohmann/json.hpp>

#include "core/base/result.hpp"
#include "daemon/ovwsd/sensor/reference.hpp"
#include "daemon/ovwsd/sensor/reference_origin.hpp"
#include "daemon/ovwsd/store/kept.hpp"

namespace ovws {

/// Converts a reference to the JSON content of its file, and back. Positions, standard errors and
/// the mean image are preserved bit for bit. Errors (Errc::invalid) name the inconsistent field.
nlohmann::json reference_content(const Reference& reference);
Result<Reference> reference_from(const nlohmann::json& content);

/// References as the item type of Kept. `bench` must outlive this object.
struct ReferenceKind {
  using Item = Reference;
  static constexpr const char *kKind = "reference", *kEvent = kKind, *kTitle = kKind,
                              *kMethod = "reference.take";
  const ReferenceBench* bench;

  std::string name(const Item& reference) const { return identity_of(*reference.origin); }
  nlohmann::json content(const Item& reference) const { return reference_content(reference); }
  Result<Item> read(const nlohmann::json& content) const { return reference_from(content); }
  std::string obstacle(const Item& reference) const { return bench->obstacle(reference); }
};
using KeptReferences = Kept<ReferenceKind>;

}  // namespace ovws
