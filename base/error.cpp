// Where a violated invariant is turned into a message.
#include "base/error.h"

namespace equilux {

void fail_check(const char* file, int line, const char* text, const std::string& values) {
  throw CheckFailure(
      values.empty()
          ? fmt::format("internal error at {}:{}: {} does not hold", file, line, text)
          : fmt::format("internal error at {}:{}: {} does not hold ({})", file, line, text, values));
}

}  // namespace equilux
