// The smaller records of a study folder; the first byte chooses between verdict, convergence and session
// protocol.
#include "protocols/session_protocol.h"
#include "stimuli/convergence.h"
#include "stimuli/verdict.h"
#include "tests/fuzz/fuzz.h"

namespace {

using namespace equilux;

void read_convergence(const std::filesystem::path& path) {
  const Convergence made = load_convergence(path);
  const std::string advice = format_advice(made);
  EQ_CHECK(find_frontier(made).size() <= made.points.size(), made.points.size());
  save_convergence(made, path);
  EQ_CHECK(format_advice(load_convergence(path)) == advice, advice);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  if (size == 0) return 0;
  constexpr const char* kNames[] = {"verdict.json", "convergence.json", "session.json"};
  const auto path = fuzz_folder().write(kNames[bytes[0] % 3], as_text(bytes + 1, size - 1));
  expect_read_or_refused(path.filename().string(), [&] {
    if (bytes[0] % 3 == 0) {
      EQ_CHECK(find_verdict({fuzz_folder().path()}).size() <= 1);
    } else if (bytes[0] % 3 == 1) {
      read_convergence(path);
    } else {
      EQ_CHECK(load_session_protocol(path).digest.size() == 64);
    }
  });
  return 0;
}
