; The installer for Windows: for the person who runs it, without an administrator. `cargo xtask dist` gives it
; VERSION, FROM (the folder of the archive), LISTS (where the lists of files are), ICON and OUT.
;
;   magician-VERSION-setup.exe /S /D=C:\Users\me\magician     without a question, and where

Unicode true
Target amd64-unicode
!include "MUI2.nsh"
!include "LogicLib.nsh"
!include "x64.nsh"

Name "Magician Studio"
OutFile "${OUT}"
InstallDir "$LOCALAPPDATA\Programs\Magician"
InstallDirRegKey HKCU "Software\Magician" "folder"
RequestExecutionLevel user
SetCompressor /SOLID lzma
ManifestDPIAware true
BrandingText "Magician ${VERSION}"

!define KEY "Software\Microsoft\Windows\CurrentVersion\Uninstall\Magician"
!define MUI_ICON "${ICON}"
!define MUI_UNICON "${ICON}"
!define MUI_WELCOMEPAGE_TEXT "See it, move it, teach it: a Dobot Magician arm, or a virtual one that answers and moves like it.$\r$\n$\r$\nIt is installed for you alone, and changes nothing of DobotStudio."
!define MUI_FINISHPAGE_RUN
!define MUI_FINISHPAGE_RUN_TEXT "Open the studio"
!define MUI_FINISHPAGE_RUN_FUNCTION Begin

!insertmacro MUI_PAGE_WELCOME
!insertmacro MUI_PAGE_LICENSE "${FROM}\licenses\LICENSE-MIT"
!insertmacro MUI_PAGE_DIRECTORY
!insertmacro MUI_PAGE_INSTFILES
!insertmacro MUI_PAGE_FINISH
!insertmacro MUI_UNPAGE_CONFIRM
!insertmacro MUI_UNPAGE_INSTFILES
!insertmacro MUI_LANGUAGE "English"
!insertmacro MUI_LANGUAGE "SimpChinese"

; An arm's USB adapter that is or was plugged in, and has no driver: Windows then knows the device, and no service for it.
; $0 becomes 1 if so.
!macro LOOK ID
  StrCpy $1 0
  ${Do}
    EnumRegKey $2 HKLM "SYSTEM\CurrentControlSet\Enum\USB\${ID}" $1
    ${If} $2 == ""
      ${ExitDo}
    ${EndIf}
    ReadRegStr $3 HKLM "SYSTEM\CurrentControlSet\Enum\USB\${ID}\$2" "Service"
    ${If} $3 == ""
      StrCpy $0 1
    ${EndIf}
    IntOp $1 $1 + 1
  ${Loop}
!macroend

Section "Magician"
  SetOutPath "$INSTDIR"
  ; What is installed, file by file, and what is deleted again: written by `cargo xtask dist`.
  !include "${LISTS}\install.nsh"
  SetOutPath "$INSTDIR"
  WriteUninstaller "$INSTDIR\uninstall.exe"
  CreateDirectory "$SMPROGRAMS\Magician"
  ; The console stays small: it says what happens, and closing it ends the studio.
  CreateShortcut "$SMPROGRAMS\Magician\Magician Studio.lnk" "$INSTDIR\bin\magician.exe" "studio --app" "$INSTDIR\magician.ico" 0 SW_SHOWMINIMIZED
  CreateShortcut "$SMPROGRAMS\Magician\Uninstall Magician.lnk" "$INSTDIR\uninstall.exe"
  CreateShortcut "$DESKTOP\Magician Studio.lnk" "$INSTDIR\bin\magician.exe" "studio --app" "$INSTDIR\magician.ico" 0 SW_SHOWMINIMIZED
  WriteRegStr HKCU "Software\Magician" "folder" "$INSTDIR"
  WriteRegStr HKCU "${KEY}" "DisplayName" "Magician Studio"
  WriteRegStr HKCU "${KEY}" "DisplayVersion" "${VERSION}"
  WriteRegStr HKCU "${KEY}" "DisplayIcon" "$INSTDIR\magician.ico"
  WriteRegStr HKCU "${KEY}" "Publisher" "The magician contributors"
  WriteRegStr HKCU "${KEY}" "UninstallString" '"$INSTDIR\uninstall.exe"'
  WriteRegStr HKCU "${KEY}" "QuietUninstallString" '"$INSTDIR\uninstall.exe" /S'
  WriteRegDWORD HKCU "${KEY}" "NoModify" 1
  WriteRegDWORD HKCU "${KEY}" "NoRepair" 1

  StrCpy $4 ""
  StrCpy $0 0
  !insertmacro LOOK "VID_10C4&PID_EA60"
  ${If} $0 = 1
    StrCpy $4 "CP210x: $\"CP210x Universal Windows Driver$\" of Silicon Labs (silabs.com)"
  ${EndIf}
  StrCpy $0 0
  !insertmacro LOOK "VID_1A86&PID_7523"
  !insertmacro LOOK "VID_1A86&PID_55D4"
  ${If} $0 = 1
    StrCpy $4 "CH340: $\"CH341SER$\" of WCH (wch-ic.com)"
  ${EndIf}
  ${If} $4 != ""
    DetailPrint "The USB adapter of the arm has no driver. It needs $4"
    MessageBox MB_ICONINFORMATION "The USB adapter of the arm has no driver yet. It needs$\r$\n$\r$\n$4$\r$\n$\r$\nThe virtual arm works without it." /SD IDOK
  ${Else}
    DetailPrint "If the arm is not found later: its USB adapter needs the driver CP210x (Silicon Labs) or CH340 (WCH)."
  ${EndIf}
SectionEnd

Function Begin
  ExecShell "" "$DESKTOP\Magician Studio.lnk"
FunctionEnd

Section "Uninstall"
  ; What the person made (settings, programs, recordings) is not ours to delete.
  Delete "$SMPROGRAMS\Magician\Magician Studio.lnk"
  Delete "$SMPROGRAMS\Magician\Uninstall Magician.lnk"
  RMDir "$SMPROGRAMS\Magician"
  Delete "$DESKTOP\Magician Studio.lnk"
  ; Only what was installed: the folder may have been the person's before.
  !include "${LISTS}\uninstall.nsh"
  ${If} ${FileExists} "$INSTDIR\bin\magician.exe"
    MessageBox MB_ICONEXCLAMATION "The studio is running. Close it and try again." /SD IDOK
    SetErrorLevel 1
    Abort
  ${EndIf}
  Delete "$INSTDIR\uninstall.exe"
  RMDir "$INSTDIR"
  DeleteRegKey HKCU "${KEY}"
  DeleteRegKey HKCU "Software\Magician"
SectionEnd
