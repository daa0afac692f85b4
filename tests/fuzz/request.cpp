/// Whatever bytes come as a request: one answer, of JSON, and no throw.
#include <cstdint>
#include <cstdlib>

#include "tests/support/decode_all.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  int answers = 0;
  ovws::handle_rpc(
      {reinterpret_cast<const char*>(data), size}, {},
      [](const ovws::RpcCall& call, const ovws::RpcReply& reply) {
        ovws::test::decode_all(call.params);
        reply(ovws::RpcResult{call.params});
      },
      [&answers](const std::string& reply, const auto&) {
        ++answers;
        if (!reply.empty() && !ovws::Json::accept(reply)) std::abort();
      });
  if (answers != 1) std::abort();
  return 0;
}
