#include "daemon/ovwsd/settings/saved_config.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "daemon/ovwsd/library/state_folder.hpp"
#include "daemon/ovwsd/settings/config_check.hpp"
#include "daemon/ovwsd/settings/settings.hpp"
#include "daemon/shared/atomic_file.hpp"
#include "daemon/shared/slm_files.hpp"
#include "proto/json_text.hpp"
#include "proto/strict_json.hpp"

namespace ovws {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr const char* kFileName = "/config.json";
constexpr const char* kRejectedSuffix = ".rejected";
constexpr int kMostRejected = 9;  // overlays that are kept
constexpr int kMaxDepth = 8;

using Group = std::vector<std::string>;

/// Groups of keys whose values depend on each other. If one key of a group was edited in the file,
/// the file's values are used for the whole group.
const std::array<Group, 4>& groups() {
  static const std::array<Group, 4> all{
      {{"camera.gain_db", "camera.gain_raw"},
       {"camera.roi.height", "camera.roi.width", "camera.roi.x", "camera.roi.y"},
       {"camera.pixel_format", "refine.black_level_dn", "refine.electrons_per_dn",
        "refine.saturation_dn"},
       {"slm.allow_primary", "slm.display"}}};
  return all;
}

Group group_of(const std::string& key) {
  for (const Group& group : groups()) {
    if (std::find(group.begin(), group.end(), key) != group.end()) return group;
  }
  return {key};
}

json tree_of(const Config& config) {
  return json_of(dump_config(config));
}

std::string pointer_of(std::string key) {
  std::replace(key.begin(), key.end(), '.', '/');
  return "/" + key;
}

/// Absolute path of the configuration file that an overlay belongs to; null: the daemon was started
/// without a file.
json owner_of(const std::string& path) {
  if (path.empty()) return nullptr;
  std::error_code unknown;
  const auto whole = fs::absolute(path, unknown);
  return (unknown ? fs::path(path) : whole).lexically_normal().string();
}

/// True if both paths are equal in canonical form, with links resolved.
bool is_same_file(const std::string& one, const std::string& other) {
  const auto canonical = [](const std::string& path) {
    std::error_code unknown;
    const auto found = fs::weakly_canonical(fs::absolute(path, unknown), unknown);
    return unknown ? fs::path(path) : found;
  };
  return canonical(one) == canonical(other);
}

/// True if an overlay with the owner `file` was saved for the configuration file `path`.
bool belongs_to(const json& file, const std::string& path) {
  if (!file.is_string() || path.empty()) return file == owner_of(path);
  return is_same_file(file.get<std::string>(), path);
}

struct Saved {
  json value, instead_of;
};

struct Overlay {
  json file;
  std::map<std::string, Saved> saved;
};

Result<Overlay> parse_overlay(const std::string& text) {
  const auto wrong = [](const std::string& reason) { return fail(Errc::invalid, "", reason); };
  const auto all = parse_strict_json(text, kMaxDepth, JsonComments::refused);
  if (!all) return wrong(all.error().reason);
  if (!all->is_object() || !all->contains("file") || !all->contains("saved") ||
      !(*all)["saved"].is_object()) {
    return wrong("it is not a file that config.save wrote: \"file\" or \"saved\" is missing");
  }
  Overlay overlay{(*all)["file"], {}};
  for (const auto& [key, entry] : (*all)["saved"].items()) {
    if (!entry.is_object() || !entry.contains("value") || !entry.contains("instead_of")) {
      return wrong(key + ": \"value\" or \"instead_of\" is missing");
    }
    overlay.saved[key] = {entry["value"], entry["instead_of"]};
  }
  return overlay;
}

/// Accepts only settings that `config.save` can write. Endpoints, key files and folders may come
/// from the configuration file only.
Result<void> check_keys(const Overlay& overlay, const json& file) {
  for (const auto& [key, entry] : overlay.saved) {
    if (!changes_live(key) || !file.contains(pointer_of(key))) {
      return fail(
          Errc::invalid, "",
          key +
              " is not a setting that config.save saves: remove it there, and set it in the "
              "configuration file");
    }
  }
  return {};
}

Result<void> apply_overlay(LoadedConfig& loaded, const Overlay& overlay) {
  json tree = tree_of(loaded.file);
  const json file = flat(loaded.file);
  if (auto known = check_keys(overlay, file); !known) return known;
  std::set<std::string> of_file;
  for (const auto& [key, entry] : overlay.saved) {
    if (file.value(pointer_of(key), json()) == entry.instead_of) continue;
    for (const std::string& one : group_of(key)) of_file.insert(one);
  }
  std::vector<std::string> saved, edited;
  for (const auto& [key, entry] : overlay.saved) {
    const std::string pointer = pointer_of(key);
    if (file.value(pointer, json()) == entry.value) continue;
    if (of_file.contains(key)) {
      edited.push_back(key);
      continue;
    }
    tree[json::json_pointer(pointer)] = entry.value;
    saved.push_back(key);
  }
  auto effective = parse_config(json_text(tree));
  if (!effective) return fail(effective.error());
  if (auto read = load_masks(effective->sensor); !read) return fail(read.error());
  if (auto usable = check_usable(*effective); !usable) {
    if (check_usable(loaded.file)) return usable;
    return {};  // the file is not usable, so the overlay may still be valid
  }
  loaded.effective = std::move(*effective);
  loaded.saved = std::move(saved);
  loaded.edited = std::move(edited);
  return {};
}

void read_overlay(LoadedConfig& loaded) {
  const auto reject = [&loaded](const Error& error) {
    loaded.invalid = true;
    loaded.unused_reason = text_of(error);
  };
  const auto text = read_small_file(*loaded.overlay);
  if (!text && text.error().code == Errc::unavailable) return;
  if (!text) return reject(text.error());
  const auto overlay = parse_overlay(*text);
  if (!overlay) return reject(overlay.error());
  if (!belongs_to(overlay->file, loaded.path)) {
    loaded.unused_reason = "its values were saved for another configuration file, " +
                           (overlay->file.is_null() ? "none" : json_text(overlay->file));
    return;
  }
  if (const auto laid = apply_overlay(loaded, *overlay); !laid) reject(laid.error());
}

/// Refuses to overwrite the saved values of another configuration file, whose daemon still needs
/// them.
Result<void> check_ours(const std::string& overlay, const json& owner) {
  const auto text = read_small_file(overlay);
  if (!text) return {};
  const auto there = parse_overlay(*text);
  if (!there || belongs_to(there->file, owner.is_string() ? owner.get<std::string>() : ""))
    return {};
  return fail(
      Errc::refused, "state.directory",
      fmt::format("{0} holds the values saved for another configuration file, {1}: give this "
                  "one a state.directory of its own, or remove {0}",
                  overlay, there->file.is_null() ? "none" : json_text(there->file)));
}

}  // namespace

std::string comma_list(const std::vector<std::string>& keys) {
  return fmt::format("{}", fmt::join(keys, ", "));
}

bool is_service_config(const std::string& path) {
  return !path.empty() && is_same_file(path, kServicePath);
}

std::optional<std::string> service_state_folder(const std::string& path) {
  if (!is_service_config(path)) return std::nullopt;
  return "/var/lib/ovws";
}

Result<LoadedConfig> load_with_saved(const std::string& path,
                                     const std::optional<std::string>& folder,
                                     const LoadedConfig* running) {
  auto file = load_config_and_masks(path);
  if (!file) return fail(file.error());
  LoadedConfig loaded;
  loaded.path = path;
  loaded.file = *file;
  loaded.effective = std::move(*file);
  auto state = state_directory_of(loaded.file.state);
  if (!state) state = folder;
  if (state) loaded.overlay = *state + kFileName;
  if (running != nullptr) loaded.overlay = running->overlay;
  if (!loaded.overlay) return loaded;
  std::error_code unknown;
  if (fs::exists(*loaded.overlay + kRejectedSuffix, unknown))
    loaded.rejected = *loaded.overlay + kRejectedSuffix;
  read_overlay(loaded);
  return loaded;
}

void set_aside_if_invalid(LoadedConfig& loaded) {
  if (!loaded.invalid) return;
  std::error_code unknown;
  std::string aside = *loaded.overlay + kRejectedSuffix;
  for (int k = 2; k <= kMostRejected && fs::exists(aside, unknown); ++k) {
    aside = fmt::format("{}{}.{}", *loaded.overlay, kRejectedSuffix, k);
  }
  if (std::rename(loaded.overlay->c_str(), aside.c_str()) == 0) {
    loaded.unused_reason += "; it was renamed to " + aside;
  } else {
    loaded.unused_reason += std::string("; it cannot be renamed: ") + std::strerror(errno);
  }
}

std::string describe_saved(const LoadedConfig& loaded) {
  std::vector<std::string> parts;
  if (!loaded.saved.empty()) {
    parts.push_back("saved values active: " + comma_list(loaded.saved) + " (" + *loaded.overlay +
                    ")");
  }
  if (!loaded.edited.empty()) {
    parts.push_back("edited in the file since they were saved, the file's values are used: " +
                    comma_list(loaded.edited));
  }
  if (!loaded.unused_reason.empty()) {
    parts.push_back("the saved values in " + *loaded.overlay +
                    " are not used: " + loaded.unused_reason);
  }
  return fmt::format("{}", fmt::join(parts, "; "));
}

SavedValues values_to_save(const LoadedConfig& loaded, const Config& in_use) {
  const json file = flat(loaded.file), now = flat(in_use);
  json saved = json::object();
  for (const std::string& changed : difference(loaded.file, in_use).live) {
    for (const std::string& key : group_of(changed)) {
      const std::string pointer = pointer_of(key);
      saved[key] = {{"value", now.value(pointer, json())},
                    {"instead_of", file.value(pointer, json())}};
    }
  }
  SavedValues values;
  for (const auto& [key, entry] : saved.items()) {
    if (entry["value"] != entry["instead_of"]) values.keys.push_back(key);
  }
  values.owner = owner_of(loaded.path);
  const json all{{"file", values.owner}, {"saved", saved}};
  values.text = json_text(all, 2) + "\n";
  return values;
}

Result<void> write_saved(const std::string& overlay, const SavedValues& values) {
  if (auto ours = check_ours(overlay, values.owner); !ours) return ours;
  if (values.keys.empty()) return remove_file(overlay);
  std::error_code ignored;  // replace_file reports a missing folder
  fs::create_directories(fs::path(overlay).parent_path(), ignored);
  return replace_file(overlay, values.text);
}

}  // namespace ovws
