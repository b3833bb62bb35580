!> Nothing stops the solver: a call that fails says so in ierr, and the session tells why.
program errors
  use, intrinsic :: iso_fortran_env, only: int32, output_unit, real64
  use insitu
  implicit none

  real(real64), target :: xyz(3, 4) = reshape(real([0,0,0, 1,0,0, 0,1,0, 0,0,1], real64), [3, 4])
  integer(int32), target :: connectivity(4, 1) = reshape([0, 1, 2, 3], [4, 1])   ! from 0: wrong here
  real(real64), target :: heat(3) = 1.0_real64                                   ! one short
  type(insitu_session) :: session
  type(insitu_mesh) :: mesh
  integer :: ierr

  call session%open(ierr=ierr, scene_text='insitu: 1' // new_line('a') // 'probs: []' // new_line('a'))
  call tell('open')
  call session%open(ierr=ierr, log_level=insitu_log_error)
  call session%mesh('tetrahedron', mesh, ierr)
  call mesh%points(xyz, ierr)
  call mesh%tetrahedra(connectivity, ierr)
  call mesh%commit(ierr)
  call tell('commit')

  connectivity = connectivity + 1                        ! set right, in place
  call mesh%changed(insitu_topology)
  call mesh%vertex_field('heat', heat, ierr)
  call mesh%commit(ierr)
  call tell('commit')
  call mesh%remove_field('heat', ierr)
  call mesh%commit(ierr)
  call tell('commit')
  call session%close(ierr)

contains

  subroutine tell(what)
    character(len=*), intent(in) :: what
    write (output_unit, '(3a)') what, ': ', insitu_status_name(ierr)
    if (ierr /= insitu_ok) write (output_unit, '(2a)') '  ', session%message()
  end subroutine tell

end program errors
