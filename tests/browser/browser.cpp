#include "browser/browser.hpp"

#include <fcntl.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <csignal>
#include <fstream>
#include <stdexcept>
#include <system_error>
#include <thread>
#include <utility>

namespace assur {
namespace {

using Json = nlohmann::json;

constexpr int kPatience = 60'000;  // ms without any message, on a machine that is busy with other tests

[[noreturn]] void give_up(const std::string& why) { throw std::runtime_error("the browser " + why); }

// Becomes the browser, which reads its orders from descriptor 3 and answers on 4.
[[noreturn]] void become(const std::string& program, const std::string& profile, int orders, int answers) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);  // it does not outlive the tests
  setpgid(0, 0);                     // to be ended with all its helpers
  // Above 4 first, for the one may stand where the other shall be.
  const int from = fcntl(orders, F_DUPFD, 10), to = fcntl(answers, F_DUPFD, 10);
  const int nowhere = open("/dev/null", O_RDWR);
  for (const auto& [descriptor, place] : {std::pair(nowhere, 0), {nowhere, 1}, {nowhere, 2}, {from, 3}, {to, 4}}) {
    if (dup2(descriptor, place) < 0) _exit(96);
  }
  const std::string folder = "--user-data-dir=" + profile;
  // No sandbox: tests also run as root and in containers, and the pages are our own.
  execl(program.c_str(), program.c_str(), "--headless=new", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage",
        "--disable-extensions", "--disable-background-networking", "--disable-component-update", "--disable-sync",
        "--no-first-run", "--hide-scrollbars", "--force-device-scale-factor=1", "--remote-debugging-pipe",
        folder.c_str(), "about:blank", nullptr);
  _exit(97);
}

std::string decoded(const std::string& base64) {
  const auto value = [](char c) {
    if (c >= 'A' && c <= 'Z') return c - 'A';
    if (c >= 'a' && c <= 'z') return c - 'a' + 26;
    if (c >= '0' && c <= '9') return c - '0' + 52;
    return c == '+' ? 62 : 63;
  };
  std::string bytes;
  unsigned bits = 0;
  int count = 0;
  for (const char c : base64) {
    if (c == '=') break;
    bits = (bits << 6U) | static_cast<unsigned>(value(c));
    count += 6;
    if (count < 8) continue;
    count -= 8;
    bytes += static_cast<char>((bits >> static_cast<unsigned>(count)) & 0xFFU);
  }
  return bytes;
}

std::string described(const Json& exception) {
  const Json& thrown = exception.value("exception", Json::object());
  return thrown.value("description", exception.value("text", "exception"));
}

}  // namespace

std::string Browser::program() { return ASSUR_CHROMIUM; }

Browser::Browser() : profile_(std::filesystem::temp_directory_path() / "assur-browser-XXXXXX") {
  if (mkdtemp(profile_.data()) == nullptr) give_up("has no folder");
  std::array<int, 2> orders{}, answers{};
  if (pipe2(orders.data(), O_CLOEXEC) != 0 || pipe2(answers.data(), O_CLOEXEC) != 0) give_up("has no pipe");
  std::signal(SIGPIPE, SIG_IGN);  // a browser that has died is an error of the next call
  process_ = fork();
  if (process_ < 0) give_up("cannot be started");
  if (process_ == 0) become(program(), profile_, orders[0], answers[1]);
  setpgid(process_, process_);  // here, too: whoever comes first
  close(orders[0]);
  close(answers[1]);
  to_ = orders[1];
  from_ = answers[0];
}

Browser::~Browser() {
  close(to_);
  close(from_);
  kill(-process_, SIGKILL);
  waitpid(process_, nullptr, 0);
  // Its helpers may still be writing while they end.
  std::error_code failed;
  for (int i = 0; i < 100; ++i) {
    std::filesystem::remove_all(profile_, failed);
    if (!std::filesystem::exists(profile_)) break;
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
}

void Browser::open(const std::filesystem::path& page, const Window& window) {
  session_.clear();
  if (!target_.empty()) call("Target.closeTarget", {{"targetId", target_}});
  target_ = call("Target.createTarget", {{"url", "about:blank"}}).at("targetId");
  session_ = call("Target.attachToTarget", {{"targetId", target_}, {"flatten", true}}).at("sessionId");
  for (const char* domain : {"Page", "Runtime", "Log", "Network"}) call(std::string(domain) + ".enable");
  call("Emulation.setDeviceMetricsOverride",
       {{"width", window.width}, {"height", window.height}, {"deviceScaleFactor", 1}, {"mobile", window.touch}});
  call("Emulation.setTouchEmulationEnabled", {{"enabled", window.touch}, {"maxTouchPoints", 2}});
  const Json scheme = {{"name", "prefers-color-scheme"}, {"value", window.dark ? "dark" : "light"}};
  call("Emulation.setEmulatedMedia", {{"features", Json::array({scheme})}});
  errors_.clear();
  loaded_ = false;
  page_ = "file://" + std::filesystem::absolute(page).string();
  call("Page.navigate", {{"url", page_}});
  while (!loaded_) notice(next_message());
}

Json Browser::evaluate(std::string_view body) {
  const Json answer = call("Runtime.evaluate", {{"expression", "(async () => {" + std::string(body) + "\n})()"},
                                                {"awaitPromise", true},
                                                {"returnByValue", true}});
  if (answer.contains("exceptionDetails")) {
    errors_.push_back(described(answer["exceptionDetails"]));
    return nullptr;
  }
  return answer.at("result").value("value", Json());
}

void Browser::mouse(const char* type, double x, double y, int buttons, double down) {
  Json event = {{"type", type}, {"x", x}, {"y", y}, {"buttons", buttons}};
  if (std::string_view(type) == "mouseWheel") {
    event["deltaX"] = 0;
    event["deltaY"] = down;
  } else if (std::string_view(type) != "mouseMoved") {
    event["button"] = "left";
    event["clickCount"] = 1;
  }
  call("Input.dispatchMouseEvent", event);
}

void Browser::drag(double x0, double y0, double x1, double y1) {
  mouse("mouseMoved", x0, y0, 0);
  mouse("mousePressed", x0, y0, 1);
  constexpr int kMoves = 5;
  for (int i = 1; i <= kMoves; ++i) mouse("mouseMoved", x0 + (x1 - x0) * i / kMoves, y0 + (y1 - y0) * i / kMoves, 1);
  mouse("mouseReleased", x1, y1, 0);
}

void Browser::move(double x, double y) { mouse("mouseMoved", x, y, 0); }

void Browser::wheel(double x, double y, double down) { mouse("mouseWheel", x, y, 0, down); }

void Browser::fingers(const char* type, double x, double y, double distance) {
  Json points = Json::array();
  if (std::string_view(type) != "touchEnd") {
    for (const int side : {-1, 1}) points.push_back({{"x", x + side * distance / 2}, {"y", y}, {"id", side + 1}});
  }
  call("Input.dispatchTouchEvent", {{"type", type}, {"touchPoints", points}});
}

void Browser::pinch(double x, double y, double from, double to) {
  fingers("touchStart", x, y, from);
  constexpr int kMoves = 5;
  for (int i = 1; i <= kMoves; ++i) fingers("touchMove", x, y, from + (to - from) * i / kMoves);
  fingers("touchEnd", x, y, to);
}

void Browser::press(const std::string& key) {
  Json event = {{"type", "keyDown"}, {"key", key}};
  if (key.size() == 1) event["text"] = key;
  call("Input.dispatchKeyEvent", event);
  call("Input.dispatchKeyEvent", {{"type", "keyUp"}, {"key", key}});
}

void Browser::screenshot(const std::filesystem::path& file) {
  const Json answer = call("Page.captureScreenshot", {{"format", "png"}});
  std::ofstream(file, std::ios::binary) << decoded(answer.at("data"));
}

Json Browser::call(const std::string& method, Json parameters) {
  const int id = ++last_call_;
  Json order = {{"id", id}, {"method", method}, {"params", std::move(parameters)}};
  if (!session_.empty()) order["sessionId"] = session_;
  const std::string text = order.dump() + '\0';
  for (std::size_t done = 0; done < text.size();) {
    const ssize_t count = write(to_, text.data() + done, text.size() - done);
    if (count <= 0) give_up("does not take " + method);
    done += static_cast<std::size_t>(count);
  }
  for (;;) {
    const Json message = next_message();
    if (message.value("id", 0) != id) {
      notice(message);
    } else if (message.contains("error")) {
      give_up("refuses " + method + ": " + message["error"].dump());
    } else {
      return message.at("result");
    }
  }
}

Json Browser::next_message() {
  for (;;) {
    if (const std::size_t end = received_.find('\0'); end != std::string::npos) {
      Json message = Json::parse(received_.substr(0, end));
      received_.erase(0, end + 1);
      return message;
    }
    pollfd ready{from_, POLLIN, 0};
    if (poll(&ready, 1, kPatience) <= 0) give_up("says nothing");
    std::array<char, 65536> chunk{};
    const ssize_t count = read(from_, chunk.data(), chunk.size());
    if (count <= 0) give_up("has ended");
    received_.append(chunk.data(), static_cast<std::size_t>(count));
  }
}

void Browser::notice(const Json& event) {
  if (event.value("sessionId", "") != session_) return;
  const std::string method = event.value("method", "");
  const Json& what = event.value("params", Json::object());
  if (method == "Page.loadEventFired") {
    loaded_ = true;
  } else if (method == "Runtime.exceptionThrown") {
    errors_.push_back(described(what.at("exceptionDetails")));
  } else if (method == "Runtime.consoleAPICalled" && (what.at("type") == "error" || what.at("type") == "assert")) {
    errors_.push_back("console." + what.at("type").get<std::string>() + ": " + what.at("args").dump());
  } else if (method == "Log.entryAdded" && what.at("entry").at("level") == "error") {
    errors_.push_back(what.at("entry").at("text"));
  } else if (method == "Network.requestWillBeSent") {
    const std::string url = what.at("request").at("url");
    if (url != page_ && !url.starts_with("data:") && !url.starts_with("blob:")) errors_.push_back("asks for " + url);
  }
}

}  // namespace assur
