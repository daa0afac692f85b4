#include "daemon/ovwsd/procedures/experiment_files.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <utility>

#include "core/port/clock.hpp"
#include "daemon/shared/encoding.hpp"
#include "proto/json_text.hpp"

namespace ovws {
namespace {

using nlohmann::json;

constexpr const char* kKind = "experiment";

/// Key that identifies the execution of a run that a file belongs to. After `anew`, files of an
/// earlier execution are ignored even if they could not be deleted.
constexpr const char* kStamp = "run_t_begun_ns";

using Part = ExperimentFiles::Part;

/// Images have a kind of their own: they take many megabytes and are read only on request.
std::string kind_of(const ExperimentRun& run, Part part = Part::cell) {
  return fmt::format("{}{}-{}", kKind, part == Part::picture ? "-picture" : "", run.name);
}

std::string name_of(Part part, std::size_t number) {
  if (part == Part::reference) return fmt::format("reference-{:02}", number);
  return fmt::format("{}-{:05}", part == Part::picture ? "picture" : "cell", number);
}

/// The header of a run.
struct Header {
  ExperimentRun run;
  std::int64_t t_opened_ns = 0;
};
/// None: the file is not a valid header.
std::optional<Header> header_of(const StateItem& item) {
  const json& content = item.content;
  if (!content.is_object() || !content.contains("request") || !content.contains("bench")) {
    return std::nullopt;
  }
  const auto request = decode<GainSweep>(content["request"]);
  const json begun = content.value("t_begun_ns", json()),
             opened = content.value("t_opened_ns", json());
  if (!request || !begun.is_number_integer() || !opened.is_number_integer()) return std::nullopt;
  return Header{{item.name, *request, content["bench"], begun.get<std::int64_t>(), false},
                opened.get<std::int64_t>()};
}

/// The image of a cell, as base64.
std::optional<std::string> picture_of(const DaemonStore& store, const ExperimentRun& run,
                                      int cell) {
  const auto kept =
      store.find(kind_of(run, Part::picture), name_of(Part::picture, std::size_t(cell)));
  if (!kept || !kept->content.is_object()) return std::nullopt;
  const json base64 = kept->content.value("base64", json());
  if (kept->content.value(kStamp, json()) != run.t_begun_ns || !base64.is_string()) {
    return std::nullopt;
  }
  return base64.get<std::string>();
}

/// All headers, the run opened longest ago first.
std::vector<Header> headers(const DaemonStore& store) {
  std::vector<Header> all;
  store.load(kKind, [&all](const StateItem& item) {
    if (auto header = header_of(item)) all.push_back(std::move(*header));
  });
  std::sort(all.begin(), all.end(),
            [](const Header& a, const Header& b) { return a.t_opened_ns < b.t_opened_ns; });
  return all;
}

}  // namespace

ExperimentRun experiment_run(const GainSweepRun& asked, json bench) {
  constexpr std::size_t kNameDigits = 16;
  const std::string all = json_text(json{{"request", to_json(asked.sweep)}, {"bench", bench}});
  return {sha256_hex(all).substr(0, kNameDigits), asked.sweep, std::move(bench), utc_ns(),
          asked.anew};
}

std::optional<ExperimentRun> ExperimentFiles::latest() const {
  const auto stored = headers(store_);
  if (stored.empty()) return std::nullopt;
  return stored.back().run;
}

std::optional<ExperimentRun> ExperimentFiles::find(const std::string& name) const {
  for (const Header& stored : headers(store_)) {
    if (stored.run.name == name) return stored.run;
  }
  return std::nullopt;
}

ExperimentFiles::Measured ExperimentFiles::measured(const ExperimentRun& run) const {
  Measured kept{std::vector<json>(run.request.arms.size()), std::vector<json>(run.request.cells())};
  store_.load(kind_of(run), [&](StateItem item) {
    if (!item.content.is_object() || item.content.value(kStamp, json()) != run.t_begun_ns) return;
    item.content.erase(kStamp);
    const json number = item.content.value("cell", item.content.value("arm", json()));
    if (!number.is_number_unsigned()) return;
    const auto k = number.get<std::size_t>();
    const auto take = [&](Part part, std::vector<json>& all) {
      if (k < all.size() && item.name == name_of(part, k)) all[k] = std::move(item.content);
    };
    take(Part::cell, kept.cells);
    take(Part::reference, kept.references);
  });
  return kept;
}

Result<void> ExperimentFiles::put_file(const std::string& kind, const std::string& name,
                                       const json& content) {
  const auto kept = store_.put_and_wait(kind, name, content);
  if (kept || store_.is_queued(kind, name)) return {};
  return fail(kept.error());
}

Result<void> ExperimentFiles::put_header(const ExperimentRun& run) {
  return put_file(kKind, run.name,
                  {{"request", to_json(run.request)},
                   {"bench", run.bench},
                   {"t_begun_ns", run.t_begun_ns},
                   {"t_opened_ns", utc_ns()}});
}

Result<void> ExperimentFiles::put(const ExperimentRun& run, Part part, int number, json content) {
  content[kStamp] = run.t_begun_ns;
  return put_file(kind_of(run, part), name_of(part, std::size_t(number)), content);
}

std::optional<std::string> ExperimentFiles::why_not_kept(const ExperimentRun& run) const {
  for (const std::string& kind : {std::string(kKind), kind_of(run), kind_of(run, Part::picture)}) {
    if (auto why = store_.why_queued(kind)) return why;
  }
  return std::nullopt;
}

Result<void> ExperimentFiles::request_picture(
    const ExperimentRun& run, int cell, std::function<void(std::optional<std::string>)> then) {
  return store_.request(
      [this, run, cell, then = std::move(then)] { then(picture_of(store_, run, cell)); });
}

Result<void> ExperimentFiles::drop_measured(const ExperimentRun& run) {
  const auto drop = [&](Part part, std::size_t count) -> Result<void> {
    for (std::size_t k = 0; k < count; ++k) {
      auto dropped = store_.drop_and_wait(kind_of(run, part), name_of(part, k));
      if (!dropped) return dropped;
    }
    return {};
  };
  if (auto dropped = drop(Part::reference, run.request.arms.size()); !dropped) return dropped;
  if (auto dropped = drop(Part::cell, run.request.cells()); !dropped) return dropped;
  return drop(Part::picture, run.request.cells());
}

/// `current` is excluded by name, because the clock may have been set back and it may not look the
/// latest.
void ExperimentFiles::drop_oldest(const std::string& current) {
  auto stored = headers(store_);
  std::erase_if(stored, [&current](const Header& one) { return one.run.name == current; });
  for (std::size_t k = 0; k + kMaxRuns <= stored.size(); ++k) {
    // The header is deleted last, so that an interrupted deletion can be continued.
    if (drop_measured(stored[k].run)) (void)store_.drop_and_wait(kKind, stored[k].run.name);
  }
}

}  // namespace ovws
