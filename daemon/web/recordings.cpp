#include "daemon/web/recordings.hpp"

#include <fcntl.h>
#include <fmt/core.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "daemon/web/access.hpp"
#include "proto/tables/record.hpp"

namespace ovws::web {
namespace {

using nlohmann::json;

constexpr const char* kList = "record.list";

/// What the error of an open() means here, and what to do.
std::string reason_of(int error, const std::string& path) {
  if (error == EACCES || error == EPERM) {
    return fmt::format(
        "ovws-web may not read {}: add the user who started it to the group ovws-data (sudo "
        "adduser USER ovws-data), log in again and restart ovws-web",
        path);
  }
  if (error == ENOENT) {
    return fmt::format(
        "{} does not exist where ovws-web runs: if the daemon runs on another machine, copy from "
        "there, e.g. scp HOST:{} .",
        path, path);
  }
  if (error == ELOOP) return path + " is a link: only recordings in the folder itself are served";
  return path + ": " + std::strerror(error);
}

/// Why the folder cannot be read; null if it can.
json unreadable(const json& folder) {
  if (!folder.is_string()) return nullptr;
  const auto path = folder.get<std::string>();
  const int opened = ::open(path.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (opened < 0) return reason_of(errno, path);
  ::close(opened);
  return nullptr;
}

}  // namespace

std::optional<DownloadQuery> parse_download(std::string_view query) {
  constexpr std::string_view kTicket = "&ticket=";
  const auto at = query.find(kTicket);
  DownloadQuery found{std::string(query.substr(0, at)), {}};
  if (at != std::string_view::npos) found.ticket = query.substr(at + kTicket.size());
  return not_plain(found.name) ? std::nullopt : std::optional(found);
}

std::string Tickets::give(const std::string& name, Clock::time_point now) {
  if (given_.size() == kMost) given_.pop_front();
  given_.push_back({random_token(), name, now + kLifetime});
  return given_.back().ticket;
}

std::deque<Tickets::Given>::iterator Tickets::find(const std::string& ticket) {
  return std::ranges::find_if(
      given_, [&ticket](const Given& given) { return is_secret(ticket, given.ticket); });
}

bool Tickets::check(const DownloadQuery& query, Clock::time_point now) {
  const auto found = find(query.ticket);
  if (found == given_.end()) return false;
  const bool is_valid = found->name == query.name && now < found->end;
  if (!is_valid) given_.erase(found);
  return is_valid;
}

void Tickets::take(const DownloadQuery& query) {
  if (const auto found = find(query.ticket); found != given_.end()) given_.erase(found);
}

OpenRecording::~OpenRecording() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

std::string OpenRecording::read(std::uint64_t offset, std::size_t most) const {
  std::string bytes(most, '\0');
  const ssize_t got = ::pread(descriptor_, bytes.data(), bytes.size(), off_t(offset));
  bytes.resize(got > 0 ? std::size_t(got) : 0);
  return bytes;
}

tl::expected<json, cli::CallFailure> list_recordings(const cli::Common& common) {
  auto list = cli::call(common, kList, json::object());
  if (list) (*list)["unreadable"] = unreadable(list->at("folder"));
  return list;
}

Result<OpenRecording> open_recording(const cli::Common& common, const std::string& name) {
  const auto list = cli::call(common, kList, json::object());
  if (!list) {
    return fail(Errc::unavailable, "name", list.error().error.at("message").get<std::string>());
  }
  const json& all = list->at("recordings");
  const bool listed =
      std::ranges::any_of(all, [&](const json& one) { return one.at("name") == name; });
  if (!listed) return fail(Errc::invalid, "name", "record.list has no recording " + name);
  return open_in_folder(list->at("folder").get<std::string>(), name);
}

Result<OpenRecording> open_in_folder(const std::string& folder, const std::string& name) {
  const std::string path = folder + "/" + name + ".h5";
  // O_NONBLOCK: opening a pipe would wait for its writer.
  const int opened = ::open(path.c_str(), O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC);
  if (opened < 0) return fail(Errc::refused, "name", reason_of(errno, path));
  struct stat about {};
  OpenRecording file(opened, ::fstat(opened, &about) == 0 ? std::uint64_t(about.st_size) : 0);
  if (!S_ISREG(about.st_mode)) return fail(Errc::refused, "name", path + " is not a file");
  return file;
}

}  // namespace ovws::web
