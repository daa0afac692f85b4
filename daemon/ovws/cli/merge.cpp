/// ovws merge: joins the parts of a study or of a replay.
#include <nlohmann/json.hpp>
#include <ostream>

#include "daemon/ovws/cli/command_line.hpp"
#include "daemon/ovws/cli/commands.hpp"
#include "daemon/ovws/cli/image_file.hpp"
#include "daemon/ovws/cli/replay_tally.hpp"
#include "daemon/ovws/cli/study_files.hpp"
#include "daemon/ovws/parts/part_file.hpp"
#include "daemon/ovws/parts/provenance.hpp"
#include "daemon/ovws/study/figure.hpp"
#include "daemon/ovws/study/studies.hpp"
#include "proto/json_text.hpp"

namespace ovws::cli {
namespace {

using nlohmann::json;
namespace fs = std::filesystem;

struct MergeOptions {
  std::vector<std::string> parts;
  std::string folder;
};

/// Facts of this run and of those that computed the parts.
json provenance_of(const PartReader& parts) {
  json facts = host_facts();
  facts["parts"] = json::array();
  for (const std::string& path : parts.paths()) facts["parts"].push_back(facts_of_part(path));
  return facts;
}

int merge_study(const Common& common, const MergeOptions& options, PartReader& parts) {
  const PartHead& head = parts.head();
  if (!head.part_of.starts_with(kPartOfStudy)) {
    return report(common, {Errc::invalid, "parts",
                           options.parts.front() + " is a part of \"" + head.part_of +
                               "\", which this version does not know"});
  }
  StudyOptions of;
  of.name = head.part_of.substr(std::string(kPartOfStudy).size());
  of.folder = options.folder;
  of.quick = head.options.at("quick").get<bool>();
  of.seed = head.options.at("seed").get<std::uint64_t>();
  const study::Study* const known = study::study_named(of.name);
  if (known == nullptr) {
    return report(common, {Errc::invalid, "parts", "there is no study " + of.name});
  }
  const study::Work work = known->prepare({of.quick, of.seed});
  if (work.items != head.items) {
    return report(common, {Errc::invalid, "parts", "the parts are of a study with other items"});
  }
  std::vector<std::string> results;
  while (true) {
    auto item = parts.next();
    if (!item) return report(common, item.error());
    if (!*item) break;
    results.push_back((*item)->result.dump());
  }
  return finish_study(common, of, work, results, provenance_of(parts));
}

/// Writes the frames in their order and counts them.
Result<ReplayTally> write_frames(PartReader& parts, const fs::path& path) {
  ReplayTally tally;
  auto written = write_output(path, [&](std::ostream& file) -> Result<void> {
    while (true) {
      const auto item = parts.next();
      if (!item) return fail(item.error());
      if (!*item) return {};
      tally.count((*item)->result);
      file << json_text((*item)->result) << '\n';
    }
  });
  if (!written) return fail(written.error());
  return tally;
}

int merge_replay(const Common& common, const MergeOptions& options, PartReader& parts) {
  const fs::path folder = options.folder;
  const auto tally = write_frames(parts, folder / "frames.jsonl");
  if (!tally) return report(common, tally.error());
  json summary = parts.head().options;
  summary["version"] = parts.head().version;
  summary.update(tally->content());
  auto written = study::write_text(json_text(summary, 2) + "\n", folder / "summary.json");
  if (written) written = write_provenance(provenance_of(parts), folder / kProvenance);
  if (!written) return report(common, written.error());
  return print_result(common, summary,
                      tally->text(summary.at("recording").at("file").get<std::string>()));
}

int merge_parts(const Common& common, const MergeOptions& options) {
  auto parts = PartReader::open(options.parts);
  if (!parts) return report(common, parts.error());
  const PartHead& head = parts->head();
  if (head.version != OVWS_VERSION) {
    return report(common, {Errc::refused, "parts",
                           options.parts.front() + " was made by version " + head.version +
                               ", and this is " + OVWS_VERSION + ": use the same version"});
  }
  if (auto made = make_folder(options.folder); !made) return report(common, made.error());
  try {
    if (head.part_of == kPartOfReplay) return merge_replay(common, options, *parts);
    return merge_study(common, options, *parts);
  } catch (const json::exception& error) {
    return report(common,
                  {Errc::invalid, "parts",
                   std::string("a part is damaged: compute the parts again: ") + error.what()});
  }
}

}  // namespace

std::string part_name(const Shard& shard) {
  return fmt::format("part-{}-of-{}", shard.number, shard.of);
}
std::string part_name(const Positions& range) {
  return fmt::format("part-{}-to-{}", range.begin, range.end);
}

void add_merge(CLI::App& app, const Common& common, int& status) {
  auto [command, options] = add_command(
      app, common, status, "merge",
      "join the parts of ovws study --shard into the study's figures, or those of ovws replay -o "
      "into one list of frames; the result does not depend on the number of parts; works offline",
      merge_parts);
  command.add_option("parts", options.parts, "all parts (JSON lines), in any order")->required();
  command.add_option("--output,-o", options.folder, "folder for the files")->required();
}

}  // namespace ovws::cli
