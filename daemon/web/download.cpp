// The part of a connection that lists recordings and sends them.
#include "daemon/web/in_pool.hpp"
#include "daemon/web/recordings.hpp"
#include "daemon/web/session.hpp"
#include "proto/json_text.hpp"
#include "proto/strict_json.hpp"

namespace ovws::web {
namespace {

using nlohmann::json;

constexpr int kMaxDownloads = 2;
constexpr std::size_t kChunkBytes = 1024 * 1024;
/// A browser that waits for its user stops to read; it loses the connection after this time.
constexpr std::chrono::minutes kSlowReader{5};

std::string listed(const cli::Common& common) {
  const auto list = list_recordings(common);
  return json_text(list ? json{{"result", *list}} : json{{"error", list.error().error}});
}

}  // namespace

Task<void> Session::recordings() {
  std::function<std::string()> work = [&common = parts_.common] { return listed(common); };
  co_await answer_from_pool("application/json", std::move(work), kSlowReader);
}

Task<std::optional<Session::Opened>> Session::open(const std::string& name) {
  const std::function<Opened()> work = [&common = parts_.common, name] {
    auto file = open_recording(common, name);
    return file ? Opened(std::make_shared<const OpenRecording>(std::move(*file)))
                : Opened(tl::make_unexpected(file.error()));
  };
  connection_.expires_never();
  co_return co_await in_pool<Opened>(callers_, connection_.socket(), work);
}

Task<void> Session::ticket(Request& parser, const RequestHead& head) {
  co_await http::async_read(connection_, buffer_, parser, net::use_awaitable);
  const auto asked = parse_strict_json(parser.get().body(), 2, JsonComments::refused);
  const json name = asked && asked->is_object() ? asked->value("name", json()) : json();
  const auto query =
      name.is_string() ? parse_download(name.get<std::string>()) : std::optional<DownloadQuery>();
  if (!query || !query->ticket.empty()) co_return co_await refuse(Refusal::malformed, head);
  if (parts_.downloads >= kMaxDownloads) co_return co_await refuse(Refusal::downloads, head);
  const auto opened = co_await open(query->name);
  if (!opened) co_return;
  json reply;
  if (*opened) {
    reply["result"]["path"] =
        std::string(kRecordingPath) + query->name + "&ticket=" + parts_.tickets.give(query->name);
  } else {
    reply["error"] = cli::failure(opened->error()).error;
  }
  connection_.expires_after(kSlowReader);
  std::string text = json_text(reply);
  co_await answer("application/json", std::move(text));
}

Task<void> Session::recording(const RequestHead& head, Right right) {
  const auto query = parse_download(std::string_view(head.target).substr(kRecordingPath.size()));
  if (!query) co_return co_await refuse(Refusal::malformed, head);
  if (right < Right::look) {
    const Refusal why = query->ticket.empty() ? Refusal::token : Refusal::ticket;
    if (!parts_.tickets.check(*query)) co_return co_await refuse(why, head);
  }
  trusted_ = true;
  if (parts_.downloads >= kMaxDownloads) co_return co_await refuse(Refusal::downloads, head);
  parts_.tickets.take(*query);  // only now: after a refusal for the limit it is still good
  const Counted counted(parts_.downloads);
  const auto opened = co_await open(query->name);
  if (!opened) co_return;
  connection_.expires_after(kSlowReader);
  if (!*opened) {
    std::string text = json_text({{"error", cli::failure(opened->error()).error}});
    co_return co_await answer(http::status::not_found, "application/json", std::move(text));
  }
  const auto file = **opened;
  http::response<http::empty_body> response;
  prepare(response, "application/octet-stream");
  response.set(http::field::content_disposition, "attachment; filename=\"" + query->name + ".h5\"");
  response.content_length(file->bytes());
  http::response_serializer<http::empty_body> serializer(response);
  co_await http::async_write_header(connection_, serializer, net::use_awaitable);
  co_await send(file);
}

/// Sends the file as long as it was when it was opened; a recording may grow meanwhile. If it
/// became shorter, the browser sees an incomplete download.
Task<void> Session::send(const std::shared_ptr<const OpenRecording>& file) {
  std::uint64_t sent = 0;
  while (sent < file->bytes()) {
    const std::size_t most = std::min<std::uint64_t>(kChunkBytes, file->bytes() - sent);
    const std::function<std::string()> work = [file, sent, most] { return file->read(sent, most); };
    const auto chunk = co_await in_pool<std::string>(callers_, connection_.socket(), work);
    if (!chunk || chunk->empty()) co_return;
    connection_.expires_after(kSlowReader);
    co_await net::async_write(connection_, net::buffer(*chunk), net::use_awaitable);
    connection_.expires_never();
    sent += chunk->size();
  }
}

}  // namespace ovws::web
