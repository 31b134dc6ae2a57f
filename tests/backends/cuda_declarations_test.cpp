// The declarations of backends/cuda.hpp against NVIDIA's headers, where CUDA is installed. The compiler does the work.
#include <cublas_v2.h>
#include <cuda_runtime_api.h>
#include <cusolverDn.h>
#include <gtest/gtest.h>

#include <type_traits>

#include "backends/cuda.hpp"

namespace assur::test {
namespace {

// Types that are passed in the same way: handles are pointers, and enumerations are int.
template <class Ours, class Theirs>
constexpr bool kAlike = std::is_pointer_v<Ours>
                            ? std::is_pointer_v<Theirs>
                            : (std::is_integral_v<Theirs> || std::is_enum_v<Theirs>)&&sizeof(Ours) == sizeof(Theirs);

template <class Ours, class Theirs>
constexpr bool kAlikeFunctions = false;
template <class Ours, class... OurArguments, class Theirs, class... TheirArguments>
requires(sizeof...(OurArguments) ==
         sizeof...(
             TheirArguments)) constexpr bool kAlikeFunctions<Ours (*)(OurArguments...), Theirs (*)(TheirArguments...)> =
    kAlike<Ours, Theirs> && (kAlike<OurArguments, TheirArguments> && ...);

#define EXPECT_ALIKE(OURS, THEIRS) EXPECT_TRUE((kAlikeFunctions<decltype(cuda::Library::OURS), decltype(&::THEIRS)>))
#define EXPECT_ALIKE_IN_DOUBLE(OURS, THEIRS) \
  EXPECT_TRUE((kAlikeFunctions<decltype(cuda::Dense<double>::OURS), decltype(&::THEIRS)>))
#define EXPECT_ALIKE_IN_FLOAT(OURS, THEIRS) \
  EXPECT_TRUE((kAlikeFunctions<decltype(cuda::Dense<float>::OURS), decltype(&::THEIRS)>))
// The headers overload some functions in C++.
#define EXPECT_ALIKE_AS(OURS, ...) \
  EXPECT_TRUE((kAlikeFunctions<decltype(cuda::Library::OURS), cudaError_t (*)(__VA_ARGS__)>))

TEST(CudaDeclarations, AreThoseOfTheHeaders) {
  EXPECT_ALIKE(cudaGetDeviceCount, cudaGetDeviceCount);
  EXPECT_ALIKE(cudaDriverGetVersion, cudaDriverGetVersion);
  EXPECT_ALIKE(cudaRuntimeGetVersion, cudaRuntimeGetVersion);
  EXPECT_ALIKE(cudaMemGetInfo, cudaMemGetInfo);
  EXPECT_ALIKE_AS(cudaMalloc, void**, std::size_t);
  EXPECT_ALIKE(cudaFree, cudaFree);
  EXPECT_ALIKE_AS(cudaMallocHost, void**, std::size_t);
  EXPECT_ALIKE(cudaFreeHost, cudaFreeHost);
  EXPECT_ALIKE(cudaStreamCreateWithFlags, cudaStreamCreateWithFlags);
  EXPECT_ALIKE(cudaStreamDestroy, cudaStreamDestroy);
  EXPECT_ALIKE(cudaStreamSynchronize, cudaStreamSynchronize);
  EXPECT_ALIKE(cudaMemcpyAsync, cudaMemcpyAsync);
  EXPECT_ALIKE(cudaMemcpy2DAsync, cudaMemcpy2DAsync);
  EXPECT_ALIKE_AS(cudaEventCreate, cudaEvent_t*);
  EXPECT_ALIKE(cudaEventDestroy, cudaEventDestroy);
  EXPECT_ALIKE(cudaEventRecord, cudaEventRecord);
  EXPECT_ALIKE(cudaEventElapsedTime, cudaEventElapsedTime);
  EXPECT_ALIKE(cudaGetLastError, cudaGetLastError);
  EXPECT_ALIKE(cudaGetErrorString, cudaGetErrorString);
  EXPECT_ALIKE(cublasCreate_v2, cublasCreate_v2);
  EXPECT_ALIKE(cublasDestroy_v2, cublasDestroy_v2);
  EXPECT_ALIKE(cublasSetStream_v2, cublasSetStream_v2);
  EXPECT_ALIKE(cusolverGetVersion, cusolverGetVersion);
  EXPECT_ALIKE(cusolverDnCreate, cusolverDnCreate);
  EXPECT_ALIKE(cusolverDnDestroy, cusolverDnDestroy);
  EXPECT_ALIKE(cusolverDnSetStream, cusolverDnSetStream);
  EXPECT_ALIKE_IN_DOUBLE(getrf_batched, cublasDgetrfBatched);
  EXPECT_ALIKE_IN_FLOAT(getrf_batched, cublasSgetrfBatched);
  EXPECT_ALIKE_IN_DOUBLE(getrs_batched, cublasDgetrsBatched);
  EXPECT_ALIKE_IN_FLOAT(getrs_batched, cublasSgetrsBatched);
  EXPECT_ALIKE_IN_DOUBLE(copy, cublasDcopy_v2);
  EXPECT_ALIKE_IN_FLOAT(copy, cublasScopy_v2);
  EXPECT_ALIKE_IN_DOUBLE(getrf_size, cusolverDnDgetrf_bufferSize);
  EXPECT_ALIKE_IN_FLOAT(getrf_size, cusolverDnSgetrf_bufferSize);
  EXPECT_ALIKE_IN_DOUBLE(getrf, cusolverDnDgetrf);
  EXPECT_ALIKE_IN_FLOAT(getrf, cusolverDnSgetrf);
  EXPECT_ALIKE_IN_DOUBLE(getrs, cusolverDnDgetrs);
  EXPECT_ALIKE_IN_FLOAT(getrs, cusolverDnSgetrs);
}

TEST(CudaDeclarations, ValuesAreThoseOfTheHeaders) {
  EXPECT_EQ(cuda::kToDevice, static_cast<int>(cudaMemcpyHostToDevice));
  EXPECT_EQ(cuda::kToHost, static_cast<int>(cudaMemcpyDeviceToHost));
  EXPECT_EQ(cuda::kPlain, static_cast<int>(CUBLAS_OP_N));
  EXPECT_EQ(cuda::kTransposed, static_cast<int>(CUBLAS_OP_T));
  EXPECT_EQ(cuda::kNoMemory, static_cast<int>(cudaErrorMemoryAllocation));
  EXPECT_EQ(cuda::kOldDriver, static_cast<int>(cudaErrorInsufficientDriver));
  EXPECT_EQ(cuda::kNonBlocking, cudaStreamNonBlocking);
}

}  // namespace
}  // namespace assur::test
