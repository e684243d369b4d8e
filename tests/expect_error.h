// Checks of the errors that bad input has to end in.
#ifndef CLOTHID_TESTS_EXPECT_ERROR_H_
#define CLOTHID_TESTS_EXPECT_ERROR_H_

#include <gtest/gtest.h>

#include <initializer_list>
#include <string>

#include "sim/base/error.h"

namespace clothid {

// Expects `function` to throw an `Error` of this kind whose message is one line and holds every one of `fragments`.
template <typename Function>
void ExpectError(const Function& function, ErrorKind kind, std::initializer_list<const char*> fragments) {
  try {
    function();
  } catch (const Error& error) {
    const std::string message = error.what();
    EXPECT_EQ(error.kind(), kind) << message;
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
    for (const char* fragment : fragments)
      EXPECT_NE(message.find(fragment), std::string::npos) << fragment << " in: " << message;
    return;
  }
  ADD_FAILURE() << "expected an Error";
}

}  // namespace clothid

#endif  // CLOTHID_TESTS_EXPECT_ERROR_H_
