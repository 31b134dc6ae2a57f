// The sanitizer of this build: gcc defines macros, clang has __has_feature.
#pragma once

#if defined(__has_feature)
#if __has_feature(address_sanitizer)
#define ASSUR_ADDRESS_SANITIZER
#elif __has_feature(thread_sanitizer)
#define ASSUR_THREAD_SANITIZER
#endif
#endif
#if defined(__SANITIZE_ADDRESS__)
#define ASSUR_ADDRESS_SANITIZER
#elif defined(__SANITIZE_THREAD__)
#define ASSUR_THREAD_SANITIZER
#endif
