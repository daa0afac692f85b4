/// Aliases for Boost.Asio and Boost.Beast, used only by server.cpp and session.cpp.
#pragma once

#include <utility>  // Boost 1.74 uses it in its coroutines and does not include it

#include <boost/asio.hpp>
#include <boost/asio/awaitable.hpp>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/detached.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>

namespace ovws::web {

namespace beast = boost::beast;
namespace http = boost::beast::http;
namespace net = boost::asio;
using tcp = net::ip::tcp;
template <class T>
using Task = net::awaitable<T>;

}  // namespace ovws::web
