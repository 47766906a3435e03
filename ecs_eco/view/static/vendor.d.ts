// vendor.js has its types from the packages it is made of (view-page).
export * from "../../../view-page/types/vendor";
