#include "daemon/ovws/parts/part_file.hpp"

#include <spdlog/fmt/fmt.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>

#include "daemon/ovws/parts/provenance.hpp"
#include "daemon/ovws/parts/share.hpp"
#include "proto/json_text.hpp"

namespace ovws {
namespace {

using nlohmann::json;
namespace fs = std::filesystem;

tl::unexpected<Error> wrong(const std::string& reason) {
  return fail(Errc::invalid, "parts", reason);
}

/// Checks that two parts belong together.
Result<void> compare(const PartHead& one, const std::string& path, const PartHead& other,
                     const std::string& other_path) {
  json a = one, b = other;
  a.erase("share");
  b.erase("share");
  if (a == b) return {};
  std::string differences;
  for (const json& change : json::diff(a, b)) {  // JSON pointers of what differs
    const json::json_pointer at(change.at("path").get<std::string>());
    differences += fmt::format("{}{}: {} and {}", differences.empty() ? "" : "; ",
                               at.to_string().substr(1), json_text(a.contains(at) ? a[at] : json()),
                               json_text(b.contains(at) ? b[at] : json()));
  }
  return wrong(fmt::format("{} and {} do not belong together: {}", path, other_path, differences));
}

/// Checks that each shard of N is there once.
Result<void> check_shards(const std::vector<PartHead>& heads,
                          const std::vector<std::string>& paths) {
  std::map<int, std::string> found;
  int of = 0;
  for (std::size_t k = 0; k < heads.size(); ++k) {
    const auto shard = parse_shard(heads[k].share);
    if (!shard) return wrong(paths[k] + " has the share " + heads[k].share + ", others have i/N");
    if (of == 0) of = shard->of;
    if (shard->of != of) {
      return wrong(
          fmt::format("{} is one of {} shards, {} one of {}", paths[0], of, paths[k], shard->of));
    }
    const auto [at, is_new] = found.emplace(shard->number, paths[k]);
    if (!is_new) {
      return wrong(
          fmt::format("shard {} is there twice: {} and {}", heads[k].share, at->second, paths[k]));
    }
  }
  std::string missing;
  for (int number = 1; number <= of; ++number) {
    if (found.contains(number)) continue;
    missing += fmt::format("{}{}/{}", missing.empty() ? "" : ", ", number, of);
  }
  if (missing.empty()) return {};
  return wrong("missing shards: " + missing);
}

/// Checks that the ranges follow each other from 0 to the number of items.
Result<void> check_ranges(const std::vector<PartHead>& heads,
                          const std::vector<std::string>& paths) {
  std::vector<std::pair<Positions, std::string>> all;
  for (std::size_t k = 0; k < heads.size(); ++k) {
    const auto range = parse_range(heads[k].share);
    if (!range) return wrong(paths[k] + " has the share " + heads[k].share + ", others have A:B");
    all.emplace_back(*range, paths[k]);
  }
  std::erase_if(all, [](const auto& one) { return one.first.begin == one.first.end; });
  std::ranges::sort(all, {}, [](const auto& one) { return one.first.begin; });
  std::uint64_t end = 0;
  std::string before;
  for (const auto& [range, path] : all) {
    if (range.begin < end) {
      return wrong(fmt::format("positions {} are there twice: in {} and {}",
                               text_of(Positions{range.begin, std::min(end, range.end)}), before,
                               path));
    }
    if (range.begin > end)
      return wrong("missing positions: " + text_of(Positions{end, range.begin}));
    end = range.end;
    before = path;
  }
  const std::uint64_t items = heads.front().items;
  if (end < items) return wrong("missing positions: " + text_of(Positions{end, items}));
  return {};
}

/// All parts are open at once, and the usual limit is 1024 files.
void allow_many_files() {
  rlimit files{};
  if (::getrlimit(RLIMIT_NOFILE, &files) != 0) return;
  files.rlim_cur = files.rlim_max;
  (void)::setrlimit(RLIMIT_NOFILE, &files);
}

tl::unexpected<Error> cannot_write(const fs::path& path, const std::string& why) {
  return fail(Errc::unavailable, "output", path.string() + " cannot be written: " + why);
}

}  // namespace

Result<void> make_folder(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (!error && ::access(folder.c_str(), W_OK | X_OK) != 0) {
    error.assign(errno, std::generic_category());
  }
  if (!error) return {};
  return fail(Errc::unavailable, "output",
              folder.string() + " is not writable: " + error.message());
}

Result<fs::path> write_part(const fs::path& folder, const std::string& name, const PartHead& head,
                            const std::function<Result<void>(const AddItem&)>& fill) {
  if (auto made = make_folder(folder); !made) return fail(made.error());
  const fs::path path = folder / (name + ".jsonl");
  const fs::path temporary = folder / fmt::format(".{}.{}.{}.tmp", name, host_name(), ::getpid());
  std::FILE* const file = std::fopen(temporary.c_str(), "we");
  if (file == nullptr) return cannot_write(temporary, std::strerror(errno));
  const auto write_line = [file](const std::string& line) {
    std::fwrite(line.data(), 1, line.size(), file);  // ferror reports a failure
  };
  write_line(json_text(head) + "\n");
  auto written = fill([&](std::uint64_t item, const std::string& result) {
    write_line(fmt::format("{{\"item\":{},\"result\":{}}}\n", item, result));
  });
  if (written) written = write_provenance(host_facts(), folder / (name + ".host.json"));
  errno = 0;
  const bool whole =
      std::fflush(file) == 0 && std::ferror(file) == 0 && ::fsync(::fileno(file)) == 0;
  if (written && !whole) written = cannot_write(path, std::strerror(errno));
  (void)std::fclose(file);
  std::error_code failed;
  if (written) fs::rename(temporary, path, failed);
  if (failed) written = cannot_write(path, failed.message());
  if (written) return path;
  fs::remove(temporary, failed);
  return fail(written.error());
}

Result<PartReader> PartReader::open(const std::vector<std::string>& paths) {
  allow_many_files();
  PartReader reader;
  for (const std::string& path : paths) {
    if (auto opened = reader.open_part(path); !opened) return fail(opened.error());
    auto same = compare(reader.heads_.front(), paths.front(), reader.heads_.back(), path);
    if (!same) return fail(same.error());
  }
  const bool shards = reader.head().share.find('/') != std::string::npos;
  auto whole = shards ? check_shards(reader.heads_, paths) : check_ranges(reader.heads_, paths);
  if (!whole) return fail(whole.error());
  for (std::size_t part = 0; part < paths.size(); ++part) {
    if (auto first = reader.read(part); !first) return fail(first.error());
  }
  return reader;
}

Result<void> PartReader::open_part(const std::string& path) {
  auto file = std::make_unique<std::ifstream>(path);
  if (!*file) {
    return fail(Errc::unavailable, "parts", path + " cannot be read: " + std::strerror(errno));
  }
  std::string line;
  std::getline(*file, line);
  const json head = json_of(line);
  try {
    heads_.push_back(head.get<PartHead>());
  } catch (const json::exception&) {
    return wrong(path + " is not a part, which `ovws study --shard` and `ovws replay -o` write");
  }
  paths_.push_back(path);
  files_.push_back(std::move(file));
  return {};
}

/// Reads the next line of a part, if there is one.
Result<void> PartReader::read(std::size_t part) {
  std::string line;
  if (!std::getline(*files_[part], line)) return {};
  PartItem read;
  try {
    json content = json::parse(line);
    read.item = content.at("item").get<std::uint64_t>();
    read.result = std::move(content.at("result"));
  } catch (const json::exception&) {
    return wrong(paths_[part] + " is damaged: a line is not an item; compute the part again");
  }
  const std::uint64_t item = read.item;
  if (item < next_item_)
    return wrong(fmt::format("item {} of {} is out of order", item, paths_[part]));
  const auto [at, is_new] = waiting_.emplace(item, Waiting{part, std::move(read)});
  if (is_new) return {};
  return wrong(fmt::format("item {} is there twice: in {} and {}", item, paths_[at->second.part],
                           paths_[part]));
}

Result<std::optional<PartItem>> PartReader::next() {
  if (next_item_ == head().items && waiting_.empty()) return std::nullopt;
  if (waiting_.empty() || waiting_.begin()->first != next_item_ || next_item_ >= head().items) {
    return wrong(
        fmt::format("item {} is missing, or an item is there that must not be: compute the "
                    "parts again",
                    next_item_));
  }
  Waiting first = std::move(waiting_.begin()->second);
  waiting_.erase(waiting_.begin());
  ++next_item_;
  if (auto more = read(first.part); !more) return fail(more.error());
  return std::move(first.line);
}

}  // namespace ovws
