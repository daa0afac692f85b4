/// The library's write-behind queue: a failed write waits, is retried and reports why, and a disk
/// that does not answer blocks only those that wait for it.
#include "daemon/ovwsd/library/library.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <future>
#include <thread>

#include "daemon/ovwsd/actor/stream_queue.hpp"
#include "daemon/ovwsd/library/named_items.hpp"
#include "tests/support/file_limit.hpp"
#include "tests/support/own_folder.hpp"
#include "tests/support/time.hpp"

namespace ovws {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr ItemKind kKind{"kind", "kind", "item", "item.measure"};

Library::Item item(const std::string& name, json content, const ItemKind& kind = kKind,
                   std::int64_t t_taken_ns = 0) {
  return {&kind, name, t_taken_ns, std::move(content), "the item " + name};
}

class Items : public testing::Test {
 protected:
  void TearDown() override { fs::remove_all(folder_); }

  fs::path file(const std::string& name) const { return fs::path(folder_) / name; }
  /// Makes writes under this name fail: a folder that is not empty has it, and cannot be set aside.
  void block(const std::string& name) const {
    for (const char* suffix : {"", ".outdated"})
      fs::create_directories(file(name + suffix) / "full");
  }
  void unblock(const std::string& name) const {
    for (const char* suffix : {"", ".outdated"}) fs::remove_all(file(name + suffix));
  }

  struct Answers {
    Library::Stored stored() {
      return [this](const Result<std::string>& result) {
        (result ? kept : refused) += 1;
        if (!result) why = result.error().reason;
      };
    }
    int kept = 0, refused = 0;
    std::string why;
  };
  void put(const std::string& name, int value, Answers& answers) {
    library_.put(item(name, {{"value", value}}), answers.stored());
  }
  bool remove(const std::string& name) {
    bool removed = false;
    library_.remove(kKind, {name}, [&](const Result<void>& done) { removed = done.has_value(); });
    return removed;
  }
  void try_again() {
    test::skip(std::chrono::seconds(2));
    while (library_.turn()) {
    }
  }
  static json value_in(const Library& library, const std::string& name) {
    const auto found = library.read(kKind, name);
    return found ? found->content["value"] : json();
  }
  json value(const std::string& name) const { return value_in(library_, name); }
  bool is_written(const std::string& name) const { return !library_.sha256(kKind, name).empty(); }
  /// The texts of the events so far that contain `words`.
  int events_with(const std::string& words) {
    int found = 0;
    while (const auto message = queue_.take()) {
      const auto* event = std::get_if<EventMessage>(&*message);
      found += event != nullptr && event->text.find(words) != std::string::npos ? 1 : 0;
    }
    return found;
  }

  const std::string folder_ = own_folder("library");
  StreamQueue queue_;
  Events events_{queue_};
  Library library_{{folder_}, events_};
};

TEST_F(Items, WhatIsRefusedWaitsAndIsWrittenWhenTheDiskTakesIt) {
  Answers a, b;
  block("kind.a.json");
  put("a", 1, a);
  EXPECT_EQ(a.refused, 1);
  ASSERT_TRUE(library_.report().reason);
  EXPECT_NE(library_.report().reason->find("kind.a.json"), std::string::npos);
  EXPECT_NE(library_.report().reason->find("; items waiting to be written again: 1"),
            std::string::npos);
  EXPECT_FALSE(is_written("a"));
  try_again();
  EXPECT_EQ(a.refused, 1) << "answered once";
  EXPECT_EQ(events_with("will not survive a restart"), 1) << "said once";
  unblock("kind.a.json");
  put("b", 2, b);
  EXPECT_EQ(b.kept, 1);
  try_again();
  EXPECT_EQ(events_with("the item a is saved"), 1);
  EXPECT_EQ(a.kept, 0) << "answered before";
  EXPECT_FALSE(library_.report().reason);
  EXPECT_EQ(library_.queued(), 0);
  EXPECT_EQ(value("a"), 1);
  EXPECT_EQ(library_.sha256(kKind, "a"), library_.read(kKind, "a")->sha256);
}

TEST_F(Items, ItIsTriedAgainWithoutAnythingNew) {
  Answers a;
  block("kind.a.json");
  put("a", 1, a);
  unblock("kind.a.json");
  test::skip(-std::chrono::hours(1));  // the next try is not due, however busy the machine is
  (void)library_.turn();
  EXPECT_FALSE(is_written("a")) << "it rests between two tries";
  test::skip(std::chrono::hours(1) + std::chrono::seconds(2));
  (void)library_.turn();
  EXPECT_TRUE(is_written("a"));
}

TEST_F(Items, TheReasonIsThatOfTheNewestThatWaitsAndGoesWithIt) {
  Answers a, z;
  block("kind.a.json");
  block("kind.z.json");
  put("z", 1, z);
  put("a", 1, a);
  EXPECT_NE(library_.report().reason->find("kind.a.json"), std::string::npos);
  EXPECT_NE(library_.report().reason->find("; items waiting to be written again: 2"),
            std::string::npos);
  unblock("kind.a.json");
  try_again();
  EXPECT_NE(library_.report().reason->find("kind.z.json"), std::string::npos);
  EXPECT_NE(library_.report().reason->find("; items waiting to be written again: 1"),
            std::string::npos);
  unblock("kind.z.json");
  try_again();
  EXPECT_FALSE(library_.report().reason);
}

TEST_F(Items, OnlyTheNewestOfANameIsWritten) {
  Answers first, second;
  block("kind.a.json");
  put("a", 1, first);
  put("a", 2, second);
  EXPECT_EQ(library_.queued(), 1);
  unblock("kind.a.json");
  try_again();
  EXPECT_EQ(value("a"), 2);
  EXPECT_EQ(events_with("the item a is saved"), 1);
}

TEST_F(Items, ARemovalThatFailsLosesNoWriteThatWaits) {
  Answers a;
  block("kind.a.json");
  put("a", 1, a);
  EXPECT_FALSE(remove("a")) << "no unlink removes a folder";
  ASSERT_TRUE(library_.report().reason);
  EXPECT_NE(library_.report().reason->find("; items waiting to be written again: 1"),
            std::string::npos);
  unblock("kind.a.json");
  try_again();
  EXPECT_TRUE(is_written("a"));
  EXPECT_EQ(value("a"), 1);
}

/// Not tested here: a read-only folder, which root can write to, and a full disk.
TEST_F(Items, ARemovedFolderIsCreatedAgain) {
  Answers a;
  fs::remove_all(folder_);
  put("a", 1, a);
  EXPECT_EQ(a.kept, 1);
  EXPECT_TRUE(fs::exists(file("kind.a.json")));
  EXPECT_FALSE(library_.report().reason);
}

TEST_F(Items, AnOutdatedItemIsNotLoadedByARestart) {
  Answers first, second;
  put("a", 1, first);
  ASSERT_EQ(first.kept, 1);
  const auto found_by_restart = [&] { return value_in(Library({folder_}, events_), "a"); };
  {
    const test::FileLimit limit(16);
    put("a", 2, second);
    EXPECT_EQ(second.refused, 1);
    EXPECT_FALSE(is_written("a")) << "the older one is outdated";
    EXPECT_EQ(found_by_restart(), json());
    EXPECT_TRUE(fs::exists(file("kind.a.json.outdated"))) << "a person may want it";
  }
  try_again();
  EXPECT_TRUE(is_written("a"));
  EXPECT_EQ(found_by_restart(), 2);
  EXPECT_FALSE(fs::exists(file("kind.a.json.outdated")));
}

TEST_F(Items, WhatIsRemovedIsNotWrittenAfterAll) {
  Answers a;
  {
    const test::FileLimit limit(16);
    put("a", 1, a);
    ASSERT_EQ(a.refused, 1);
    EXPECT_TRUE(remove("a"));
  }
  EXPECT_EQ(library_.queued(), 0);
  EXPECT_FALSE(library_.report().reason);
  try_again();
  EXPECT_EQ(value("a"), json());
}

TEST_F(Items, MoreThanItsMemoryIsNotKeptAndTakesNoOthersPlace) {
  constexpr ItemKind kTwo{"two", "two", "item", "item.measure", 2};
  Answers a, large, more;
  library_.put(item("a", 1, kTwo), a.stored());
  block("two.large.json");
  const std::string text(Library::kMaxQueuedBytes - 4096, 'x');
  library_.put(item("large", text, kTwo), large.stored());
  EXPECT_EQ(large.refused, 1);
  library_.put(item("more", std::string(8192, 'x'), kTwo), more.stored());
  EXPECT_EQ(more.refused, 1);
  EXPECT_NE(more.why.find("MiB already wait to be written"), std::string::npos);
  EXPECT_EQ(library_.queued(), 1);
  EXPECT_TRUE(library_.read(kTwo, "a"));
}

TEST_F(Items, AnOutdatedItemIsNotLoadedEvenIfTheNewOneIsTooLarge) {
  Answers first, second;
  put("a", 1, first);
  ASSERT_EQ(first.kept, 1);
  library_.put(item("a", std::string(Library::kMaxQueuedBytes, 'x')), second.stored());
  EXPECT_EQ(second.refused, 1);
  EXPECT_EQ(library_.queued(), 0);
  EXPECT_EQ(value("a"), json());
  EXPECT_TRUE(fs::exists(file("kind.a.json.outdated")));
}

TEST_F(Items, WhatAnItemReplacesIsRemovedOnceItIsWritten) {
  Answers a;
  put("old", 1, a);
  block("kind.new.json");
  Library::Item newer = item("new", {{"value", 2}});
  newer.replaces = {"old"};
  library_.put(newer);
  EXPECT_EQ(value("old"), 1);
  unblock("kind.new.json");
  try_again();
  EXPECT_EQ(value("new"), 2);
  EXPECT_EQ(value("old"), json());
}

TEST_F(Items, TheOldestOfAKindMakesRoomAndTheNewestStaysWhateverTheTimeOfDay) {
  constexpr ItemKind kFew{"few", "few", "item", "item.measure", 2};
  const auto names = [&] {
    std::vector<std::string> found;
    library_.load(kFew, [&](const StateItem& one) -> Result<void> {
      found.push_back(one.name);
      return {};
    });
    return found;
  };
  library_.put(item("a", {{"t_taken_ns", 5}}, kFew, 5));
  library_.put(item("b", {{"t_taken_ns", 6}}, kFew, 6));
  library_.put(item("c", {{"t_taken_ns", 7}}, kFew, 7));
  EXPECT_EQ(names(), (std::vector<std::string>{"b", "c"}));
  library_.put(item("d", {{"t_taken_ns", 1}}, kFew, 1));
  EXPECT_EQ(names(), (std::vector<std::string>{"c", "d"}));
}

TEST_F(Items, AFileThatCannotBeUsedIsReportedAndLeft) {
  Answers a;
  put("a", 1, a);
  put("b", 2, a);
  fs::copy_file(file("kind.b.json"), file("kind.b copy.json"));
  fs::resize_file(file("kind.b.json"), fs::file_size(file("kind.b.json")) / 2);
  library_.load(kKind, [](const StateItem& one) -> Result<void> {
    EXPECT_EQ(one.name, "a");
    return fail(Errc::invalid, "value", "is wrong");
  });
  EXPECT_FALSE(is_written("a"));
  EXPECT_EQ(events_with("is not used, and left as it is"), 3);
  EXPECT_TRUE(fs::exists(file("kind.a.json")));
  EXPECT_TRUE(fs::exists(file("kind.b.json")));
}

struct NumberItem {
  using Item = int;
  static constexpr const ItemKind& kKind = ovws::kKind;
  static constexpr std::size_t kMost = 2;
  static constexpr const char *kRemove = "item.delete", *kMissing = "item.list lists them";
  static std::int64_t time(int /*number*/) { return 1; }
  static json encode(int number) { return {{"value", number}}; }
  static Result<int> decode(const json& content) { return content["value"].get<int>(); }
  static int in_memory(int number) { return number; }
};

TEST_F(Items, ANewNameTakesNoFileThatIsThereAndIsNotWrittenAfterItsRefusal) {
  NamedItems<NumberItem> named(library_);
  Result<void> added;
  const auto add = [&](const char* name) {
    named.add(name, std::make_shared<int>(1), [&](const Result<void>& done) { added = done; });
    return added.has_value();
  };
  std::ofstream(file("kind.a.json")) << "of a backup";
  EXPECT_FALSE(add("a"));
  EXPECT_EQ(added.error().field, "name");
  EXPECT_EQ(fs::file_size(file("kind.a.json")), 11U);
  fs::rename(folder_, folder_ + ".away");
  std::ofstream(folder_) << "no folder";
  EXPECT_FALSE(add("b"));
  fs::remove(folder_);
  fs::rename(folder_ + ".away", folder_);
  try_again();
  EXPECT_FALSE(fs::exists(file("kind.b.json")));
  EXPECT_EQ(library_.queued(), 0);
  EXPECT_TRUE(named.all().empty());
  EXPECT_TRUE(add("b"));
}

TEST_F(Items, WithoutAFolderNothingIsKeptAndTheReasonIsSaid) {
  ::unsetenv("STATE_DIRECTORY");
  Library none({}, events_);
  EXPECT_FALSE(none.report().directory);
  EXPECT_TRUE(none.report().reason);
  Answers a;
  none.put(item("a", {{"value", 1}}), a.stored());
  EXPECT_EQ(a.refused, 1) << a.kept;
  none.remove(kKind, {"a"}, [](const Result<void>& done) { EXPECT_TRUE(done); });
  none.load(kKind, [](const StateItem&) -> Result<void> {
    ADD_FAILURE();
    return {};
  });
  ::setenv("STATE_DIRECTORY", (folder_ + ":/elsewhere").c_str(), 1);
  Library some({}, events_);
  ::unsetenv("STATE_DIRECTORY");
  EXPECT_EQ(some.report().directory, folder_);
  EXPECT_FALSE(some.report().reason);
  some.put(item("a", {{"value", 1}}), a.stored());
  EXPECT_EQ(a.kept, 1);
}

/// A library whose disk thread has no thread, unless a test makes one: everything waits.
class OnDisk : public testing::Test {
 protected:
  void TearDown() override { fs::remove_all(folder_); }
  void take_turns() {
    while (library_.turn()) {
    }
  }

  const std::string folder_ = own_folder("on_disk");
  const fs::path file_ = fs::path(folder_) / "kind.a.json";
  StreamQueue queue_;
  Events events_{queue_};
  Disk disk_;
  Library library_{{folder_}, events_, &disk_};
};

TEST_F(OnDisk, ARemovalSucceedsIfAWriteReplacesItBeforeItsTurn) {
  disk_.begin();  // without a thread
  library_.put(item("a", {{"value", 1}}));
  take_turns();
  int removed = 0;
  library_.remove(kKind, {"a"}, [&](const Result<void>& done) { removed += done ? 1 : 0; });
  library_.put(item("a", {{"value", 2}}));
  take_turns();
  EXPECT_EQ(removed, 1);
  EXPECT_EQ(library_.read(kKind, "a")->content["value"], 2);
}

TEST_F(OnDisk, ARemovalOfTwoItemsFailsIfOneCannotBeRemovedThoughTheOtherIsReplaced) {
  disk_.begin();  // without a thread
  fs::create_directories(file_ / "full");
  int failed = 0;
  library_.remove(kKind, {"a", "b"}, [&](const Result<void>& done) { failed += done ? 0 : 1; });
  library_.put(item("b", {{"value", 2}}));
  take_turns();
  EXPECT_EQ(failed, 1);
}

TEST_F(OnDisk, TwoRemovalsThatFailLoseNoWriteThatWaits) {
  disk_.begin();  // without a thread
  fs::create_directories(file_ / "full");
  library_.put(item("a", {{"value", 1}}));
  int failed = 0;
  for (int k = 0; k < 2; ++k) {
    library_.remove(kKind, {"a"}, [&](const Result<void>& done) { failed += done ? 0 : 1; });
  }
  take_turns();
  EXPECT_EQ(failed, 2);
  EXPECT_EQ(library_.queued(), 1);
  fs::remove_all(file_);
  test::skip(std::chrono::seconds(2));
  take_turns();
  EXPECT_EQ(library_.read(kKind, "a")->content["value"], 1);
}

/// Of a kind with a limited number of items, the oldest is deleted for each that is added. A
/// deletion that waits keeps the write that it replaces, in case it fails.
TEST_F(OnDisk, DeletionsDoNotFillTheMemoryWhileItStandsStill) {
  constexpr std::size_t kItem = Library::kMaxQueuedBytes / 8;
  disk_.begin();  // without a thread
  int refused = 0;
  for (int k = 0; k < 12; ++k) {
    const std::string name = "item-" + std::to_string(k);
    library_.put(item(name, std::string(kItem, 'x')), [&](const Result<std::string>& kept) {
      refused += kept || kept.error().code == Errc::refused ? 0 : 1;
    });
    library_.remove(kKind, {name}, [](const Result<void>&) {});
  }
  EXPECT_EQ(refused, 5);
}

/// The disk thread waits for a disk that does not answer until the test releases it.
TEST_F(OnDisk, WhileItStandsStillNobodyWaits) {
  disk_.each_turn([&] { return library_.turn(); });
  std::promise<void> go;
  std::atomic<bool> stop{false};
  disk_.begin();
  disk_.post([&] { go.get_future().wait(); });
  std::thread thread([&] {
    while (!stop) disk_.do_work();
    disk_.on_close();
  });
  std::atomic<int> kept{0};
  library_.put(item("a", {{"value", 1}}),
               [&](const Result<std::string>& done) { kept += done ? 1 : 0; });
  EXPECT_EQ(library_.queued(), 1);
  int refused = 0;
  for (int request = 0; request < Disk::kMaxRequests + 1; ++request) {
    refused += disk_.request([] {}) ? 0 : 1;
  }
  EXPECT_EQ(refused, 1);
  EXPECT_EQ(kept, 0);
  stop = true;
  go.set_value();
  thread.join();
  EXPECT_EQ(kept, 1) << "written before the thread ends";
  EXPECT_TRUE(fs::exists(file_));
}

}  // namespace
}  // namespace ovws
