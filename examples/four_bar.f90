! Runs a four-bar over its time grid from Fortran, by iso_c_binding, and prints the range of its rocker's angle.
!
!   gfortran four_bar.f90 $(pkg-config --libs --static assur) -o four_bar && ./four_bar

module assur
  use, intrinsic :: iso_c_binding
  implicit none

  ! Functions of assur/assur.h. Handles are pointers; strings end with c_null_char.
  interface
    integer(c_int32_t) function assur_scene_open(name, scene) bind(c)
      import
      character(kind=c_char), intent(in) :: name(*)
      type(c_ptr), intent(out) :: scene
    end function
    integer(c_int32_t) function assur_scene_set(scene, names, values, count) bind(c)
      import
      type(c_ptr), value :: scene
      type(c_ptr), intent(in) :: names(*)
      real(c_double), intent(in) :: values(*)
      integer(c_size_t), value :: count
    end function
    integer(c_int32_t) function assur_prepare(scene, options, plan) bind(c)
      import
      type(c_ptr), value :: scene, options
      type(c_ptr), intent(out) :: plan
    end function
    integer(c_int32_t) function assur_plan_time(plan, start, end, step) bind(c)
      import
      type(c_ptr), value :: plan
      real(c_double), intent(out) :: start, end, step
    end function
    integer(c_int32_t) function assur_simulator_new(plan, settings, simulator) bind(c)
      import
      type(c_ptr), value :: plan, settings
      type(c_ptr), intent(out) :: simulator
    end function
    integer(c_size_t) function assur_simulator_column_count(simulator) bind(c)
      import
      type(c_ptr), value :: simulator
    end function
    integer(c_int32_t) function assur_simulator_column(simulator, name, column) bind(c)
      import
      type(c_ptr), value :: simulator
      character(kind=c_char), intent(in) :: name(*)
      integer(c_size_t), intent(out) :: column
    end function
    ! values: (columns, rows), as Fortran stores them
    integer(c_int32_t) function assur_simulator_run(simulator, times, count, values, row_stride, rows, status) bind(c)
      import
      type(c_ptr), value :: simulator, times, status
      integer(c_size_t), value :: count, row_stride
      real(c_double), intent(out) :: values(*)
      integer(c_size_t), intent(out) :: rows
    end function
    type(c_ptr) function assur_error() bind(c)
      import
    end function
    subroutine assur_simulator_free(simulator) bind(c)
      import
      type(c_ptr), value :: simulator
    end subroutine
    subroutine assur_plan_free(plan) bind(c)
      import
      type(c_ptr), value :: plan
    end subroutine
    subroutine assur_scene_free(scene) bind(c)
      import
      type(c_ptr), value :: scene
    end subroutine
  end interface

contains

  ! Stops with the text of the library if a function returned an error.
  subroutine check(result)
    integer(c_int32_t), intent(in) :: result
    character(kind=c_char), pointer :: text(:)
    integer :: length
    if (result >= 0) return
    call c_f_pointer(assur_error(), text, [4096])
    do length = 0, 4094
      if (text(length + 1) == c_null_char) exit
    end do
    print *, text(1:length)
    error stop 1
  end subroutine

end module

program four_bar
  use assur
  implicit none
  type(c_ptr) :: scene, plan, simulator, names(1)
  character(kind=c_char, len=8), target :: rocker = 'rocker1' // c_null_char
  real(c_double), allocatable :: motion(:, :)
  real(c_double) :: start, end, step
  integer(c_size_t) :: columns, rows, room, angle

  call check(assur_scene_open('four_bar:1' // c_null_char, scene))
  names(1) = c_loc(rocker)
  call check(assur_scene_set(scene, names, [1.4_c_double], 1_c_size_t))
  call check(assur_prepare(scene, c_null_ptr, plan))
  call check(assur_simulator_new(plan, c_null_ptr, simulator))
  call check(assur_simulator_column(simulator, 'rocker_angle' // c_null_char, angle))

  call check(assur_plan_time(plan, start, end, step))
  room = nint((end - start) / step) + 1
  columns = assur_simulator_column_count(simulator)
  allocate(motion(columns, room))
  call check(assur_simulator_run(simulator, c_null_ptr, room, motion, columns, rows, c_null_ptr))
  print '(i0, a, f9.6, a, f9.6, a)', rows, ' rows; the rocker turns from', minval(motion(angle + 1, 1:rows)), ' to', &
    maxval(motion(angle + 1, 1:rows)), ' rad'

  call assur_simulator_free(simulator)
  call assur_plan_free(plan)
  call assur_scene_free(scene)
end program
